#!/usr/bin/python3
"""Recordings as other people's programs lay them out, made from one simulated flight. Each must be localized by one
command as well as the flight itself.

usage: other_recordings.py EDGE_MCL SOURCE_DIRECTORY
"""
import json
import os
import shutil
import sys
import tempfile

sys.dont_write_bytecode = True  # no .pyc of command_line.py in the source directory
from command_line import INPUT, OK, USAGE, Cases, check, failures, write

SCENARIO = '''model: %(maps)s/office.obj
camera: %(source)s/test/data/small_camera.yaml
rate: 15
path:
  - {time: 0, position: [1.0, 1.2, 1.3], yaw_deg: 35}
  - {time: 1.5, position: [1.6, 1.6, 1.4], yaw_deg: 55}
  - {time: 3, position: [2.4, 1.7, 1.4], yaw_deg: 75}
'''
START_NS = 1403636579763555584


def table(path):
    with open(path) as lines:
        return [line.split() for line in lines if line.strip() and line[0] != '#']


def localize(c, recording, *options):
    r = c.run('localize', recording, '--json', '--out', os.path.join(c.folder, 'est.txt'), *options)
    check(r.returncode == OK, '%s: %d %s' % (recording, r.returncode, r.stderr[-600:]))
    return json.loads(r.stdout) if r.returncode == OK else {}


def median_cm(summary):
    return 100 * summary.get('position_error_median_m', 1e7)


def nanoseconds(text):
    seconds, digits = text.split('.')
    return START_NS + int(seconds) * 10**9 + int(digits.ljust(9, '0'))


def initial_pose(flight):
    """The initial pose as x,y,z,roll,pitch,yaw of the camera's optical frame."""
    import math
    for line in open(os.path.join(flight, 'sequence.yaml')):
        if line.startswith('initial_pose'):
            x, y, z, qx, qy, qz, qw = [float(v) for v in line.split('[')[1].split(']')[0].split(',')]
    roll = math.atan2(2 * (qw * qx + qy * qz), 1 - 2 * (qx * qx + qy * qy))
    pitch = math.asin(max(-1, min(1, 2 * (qw * qy - qz * qx))))
    yaw = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
    return ','.join('%.9f' % v for v in (x, y, z, *map(math.degrees, (roll, pitch, yaw))))


def euroc(flight, folder):
    """As the ASL group's tools write it: nanoseconds, w first, the camera in the body by T_BS (here 10 cm ahead)."""
    camera, truth = (os.path.join(folder, 'mav0', name) for name in ('cam0', 'state_groundtruth_estimate0'))
    os.makedirs(os.path.join(camera, 'data'))
    os.makedirs(truth)
    with open(os.path.join(camera, 'data.csv'), 'w') as csv:
        csv.write('#timestamp [ns],filename\r\n')
        for time, name in table(os.path.join(flight, 'rgb.txt')):
            stamp = nanoseconds(time)
            csv.write('%d,%d.png\r\n' % (stamp, stamp))
            shutil.copy(os.path.join(flight, name), os.path.join(camera, 'data', '%d.png' % stamp))
    with open(os.path.join(truth, 'data.csv'), 'w') as csv:
        csv.write('#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n')
        for time, x, y, z, qx, qy, qz, qw in table(os.path.join(flight, 'groundtruth.txt')):
            csv.write(','.join([str(nanoseconds(time)), x, y, z, qw, qx, qy, qz]) + '\n')
    keys = {}
    for line in open(os.path.join(flight, 'camera.yaml')):
        key, _, value = line.partition(':')
        keys.setdefault(key.strip(), value.strip())
    text = open(os.path.join(flight, 'camera.yaml')).read()
    lists = [[float(v) for v in part.split(']')[0].split(',')] for part in text.split('[')[1:]]
    matrix, distortion = [values for values in lists if len(values) >= 4][:2]
    write(os.path.join(camera, 'sensor.yaml'),
          'sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n'
          'resolution: [%s, %s]\ncamera_model: pinhole\nintrinsics: %s\ndistortion_model: radial-tangential\n'
          'distortion_coefficients: %s\n' % (keys['image_width'], keys['image_height'],
                                             [matrix[0], matrix[4], matrix[2], matrix[5]], distortion))


def photographs(flight, folder):
    os.makedirs(folder)
    for i, (_, name) in enumerate(table(os.path.join(flight, 'rgb.txt'))):
        shutil.copy(os.path.join(flight, name), os.path.join(folder, 'img_%d.png' % (i + 1)))


def folders(c, flight, plain):
    model, camera = (os.path.join(flight, name) for name in ('model.obj', 'camera.yaml'))
    pose = initial_pose(flight)
    layout = os.path.join(c.folder, 'V1_01_easy')
    euroc(flight, layout)
    for path in (layout, os.path.join(layout, 'mav0'), os.path.join(layout, 'mav0', 'cam0')):
        summary = localize(c, path, '--model', model, '--initial-pose', pose)
        error = median_cm(summary)
        # There is no odometry in it. Steady motion does as well to a centimetre in this flight.
        check(error < plain + 1, '%s: %.2f cm, the flight itself %.2f cm' % (path, error, plain))
    # The output is in seconds.
    first = table(os.path.join(c.folder, 'est.txt'))[0][0]
    check(first.startswith('1403636579.7'), 'time of the first pose: ' + first)

    shots = os.path.join(c.folder, 'shots')
    photographs(flight, shots)
    summary = localize(c, shots, '--model', model, '--initial-pose', pose, '--camera', camera)
    check(summary.get('states', {}).get('tracking', 0) >= 40, 'photographs: %s' % summary.get('states'))
    estimate, truth = table(os.path.join(c.folder, 'est.txt')), table(os.path.join(flight, 'groundtruth.txt'))
    far = max(max(abs(float(a) - float(b)) for a, b in zip(e[1:4], t[1:4])) for e, t in zip(estimate, truth))
    check(len(estimate) == len(truth) and far < 0.1, 'photographs: %d poses, off by %.3f m' % (len(estimate), far))

    for status, words, arguments in (
            (INPUT, '--camera', ('localize', shots, '--model', model)),
            (INPUT, '--initial-pose', ('localize', shots, '--model', model, '--camera', camera)),
            (USAGE, 'only a bag', ('localize', flight, shots)),
            (USAGE, '--topics', ('localize', flight, '--topics', 'image=/a'))):
        r = c.run(*arguments)
        check(r.returncode == status and words in r.stderr, '%s: %d %s' % (arguments, r.returncode, r.stderr))


def bags(c, flight):
    try:
        import rosbag
    except ImportError:
        print('SKIPPED: bags, because there is no rosbag module')
        return
    model, whole = os.path.join(flight, 'model.obj'), os.path.join(c.folder, 'whole.bag')
    r = c.run('bag', flight, whole)
    check(r.returncode == OK, 'bag: ' + r.stderr)
    parts = [os.path.join(c.folder, 'flight_%d.bag' % i) for i in range(3)]
    crop = os.path.join(c.folder, 'crop.bag')
    with rosbag.Bag(whole) as source:
        start, length = source.get_start_time(), source.get_end_time() - source.get_start_time()
        written = [rosbag.Bag(part, 'w') for part in parts] + [rosbag.Bag(crop, 'w')]
        for topic, message, time in source.read_messages():
            number = min(2, int(3 * (time.to_sec() - start) / (length + 1e-9)))
            written[number].write(topic, message, time)
            # A driver that sends a part of the sensor: 16 columns and 8 rows are missing at the left and at the top.
            if topic == '/camera/camera_info':
                message.roi.x_offset, message.roi.y_offset = 16, 8
                message.roi.width, message.roi.height = message.width - 24, message.height - 16
            elif topic == '/camera/image_raw':
                size, rows = message.step // message.width, []
                for y in range(8, message.height - 8):
                    begin = y * message.step
                    rows.append(message.data[begin + 16 * size:begin + (message.width - 8) * size])
                message.data = b''.join(rows)
                message.width, message.height = message.width - 24, message.height - 16
                message.step = message.width * size
            if topic != '/camera/mask':
                written[3].write(topic, message, time)
        for bag in written:
            bag.close()
    one = localize(c, whole, '--model', model)
    poses = open(os.path.join(c.folder, 'est.txt')).read()
    r = c.run('localize', parts[2], parts[0], parts[1], '--model', model, '--out', os.path.join(c.folder, 'parts.txt'))
    check(r.returncode == OK and open(os.path.join(c.folder, 'parts.txt')).read() == poses,
          'a bag in parts: %d %s' % (r.returncode, r.stderr))
    part = localize(c, crop, '--model', model)
    error, before = median_cm(part), median_cm(one)
    check(error < before + 0.3, 'a region of interest: %.2f cm, the whole image %.2f cm' % (error, before))


def main():
    tool, source = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        c = Cases(tool, folder)
        scenario, flight = os.path.join(folder, 'flight.yaml'), os.path.join(folder, 'flight')
        write(scenario, SCENARIO % {'maps': os.path.join(source, 'maps'), 'source': source})
        r = c.run('simulate', scenario, flight)
        check(r.returncode == OK, r.stderr)
        plain = median_cm(localize(c, flight))
        folders(c, flight, plain)
        bags(c, flight)
    sys.exit(1 if failures else 0)


if __name__ == '__main__':
    main()
