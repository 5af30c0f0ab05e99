#!/usr/bin/python3
"""What a robot's sensors do wrong: the localizer says so, gives no wrong pose, and recovers."""
import copy
import math
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import rosbag
import rospy
import rostest
from edge_mcl.msg import Status
from edge_mcl.srv import SetPose, UseFile
from geometry_msgs.msg import PoseWithCovarianceStamped
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage

NAMESPACES = ['plain', 'skip_update', 'use_last', 'unmasked']


def difference(a, b):
    metres = math.dist((a.position.x, a.position.y, a.position.z),
                       (b.position.x, b.position.y, b.position.z))
    dot = abs(sum(getattr(a.orientation, k) * getattr(b.orientation, k) for k in 'xyzw'))
    return metres, math.degrees(2 * math.acos(min(1.0, dot)))


def at(message, stamp):
    message = copy.deepcopy(message)
    message.header.stamp = stamp
    return message


class Recording:
    """A simulated flight as messages."""

    def __init__(self, folder):
        bag_file = os.path.join(folder, 'flight.bag')
        subprocess.run([os.environ['EDGE_MCL_TOOL'], 'simulate',
                        os.path.join(os.environ['EDGE_MCL_TEST_DATA'], 'small_flight.yaml'), bag_file],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        names = {'/camera/image_raw': 'image', '/camera/camera_info': 'info', '/camera/mask': 'mask',
                 '/ground_truth': 'truth', '/tf': 'tf'}
        frames = {}
        with rosbag.Bag(bag_file) as bag:
            for topic, message, stamp in bag.read_messages():
                if topic in names:
                    frames.setdefault(stamp.to_nsec(), {})[names[topic]] = message
                elif topic == '/initialpose':
                    self.initial_pose = message
                elif topic == '/tf_static':
                    self.mounting = message
        self.frames = [frames[k] for k in sorted(frames) if 'image' in frames[k]]


class Faults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.recording = Recording(cls.folder.name)
        cls.statuses, cls.poses, cls.changed = {}, {}, threading.Condition()
        cls.publishers = {}
        cls.keep_alive = []
        for ns in NAMESPACES:
            cls.statuses[ns], cls.poses[ns] = {}, {}
            for topic, kind in (('image', Image), ('mask', Image), ('camera_info', CameraInfo),
                                ('initialpose', PoseWithCovarianceStamped)):
                cls.publishers[ns, topic] = rospy.Publisher('/%s/%s' % (ns, topic), kind,
                                                            queue_size=20)
            cls.keep_alive += [
                rospy.Subscriber('/%s/localizer/status' % ns, Status, cls.store(cls.statuses[ns])),
                rospy.Subscriber('/%s/pose' % ns, PoseWithCovarianceStamped, cls.store(cls.poses[ns]))]
        cls.tf = rospy.Publisher('/tf', TFMessage, queue_size=100)
        cls.tf_static = rospy.Publisher('/tf_static', TFMessage, queue_size=1, latch=True)
        cls.tf_static.publish(cls.recording.mounting)
        for ns in NAMESPACES:
            rospy.wait_for_service('/%s/localizer/set_pose' % ns, 30)
            for topic in ('image', 'camera_info', 'initialpose'):
                cls.wait(lambda p=cls.publishers[ns, topic]: p.get_num_connections() > 0)
        cls.wait(lambda: cls.tf.get_num_connections() >= len(NAMESPACES))
        # Time goes on from test to test: each begins where the one before ended.
        cls.now = 100.0

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def store(cls, target):
        def callback(message):
            with cls.changed:
                target[message.header.stamp.to_nsec()] = message
                cls.changed.notify_all()
        return callback

    @staticmethod
    def wait(condition, seconds=10):
        until = time.time() + seconds
        while not condition():
            if time.time() > until:
                return False
            time.sleep(0.02)
        return True

    def begin(self, ns='plain'):
        """Sets the initial pose; the frames that follow start at the first of the recording."""
        Faults.now += 2  # no odometry in between
        self.start = self.now
        pose = at(self.recording.initial_pose, rospy.Time.from_sec(self.now))
        answer = rospy.ServiceProxy('/%s/localizer/set_pose' % ns, SetPose)(pose)
        self.assertTrue(answer.success, answer.message)

    def stamp(self, i):
        return rospy.Time.from_sec(self.start + i / 15.0)

    def send_tf(self, i, spoil=None):
        message = copy.deepcopy(self.recording.frames[i]['tf'])
        message.transforms[0].header.stamp = self.stamp(i)
        if spoil:
            spoil(message.transforms[0].transform)
        self.tf.publish(message)

    def send(self, i, ns='plain', image=None, mask=None, info=None, tf=True):
        """Publishes a moment and returns what the localizer says of it."""
        frame, stamp = self.recording.frames[i], self.stamp(i)
        Faults.now = max(self.now, stamp.to_sec())
        if tf:
            self.send_tf(i)
        if info is not False:
            self.publishers[ns, 'camera_info'].publish(at(info or frame['info'], stamp))
            time.sleep(0.01)
        if mask is not None:
            self.publishers[ns, 'mask'].publish(at(mask, stamp))
        self.publishers[ns, 'image'].publish(at(image or frame['image'], stamp))
        key = stamp.to_nsec()
        with self.changed:
            self.changed.wait_for(lambda: key in self.statuses[ns], 10)
            self.assertIn(key, self.statuses[ns], 'no answer to image %d' % i)
            return self.statuses[ns][key]

    def error(self, i, ns='plain'):
        key = self.stamp(i).to_nsec()
        with self.changed:
            self.changed.wait_for(lambda: key in self.poses[ns], 10)
            pose = self.poses[ns][key].pose.pose
        return difference(pose, self.recording.frames[i]['truth'].pose)

    def track(self, first, last, ns='plain', **more):
        """Good images; the last one must be tracked within 5 cm and 1.5 degrees."""
        for i in range(first, last):
            status = self.send(i, ns, **more)
        metres, degrees = self.error(last - 1, ns)
        self.assertEqual(status.state_name, 'tracking', '%s; off by %.3f m, %.2f deg: %s' % (
            status.problem, metres, degrees, status))
        self.assertLess(metres, 0.05)
        self.assertLess(degrees, 1.5)
        return status

    def test_black_images_then_recovery(self):
        self.begin()
        self.track(0, 10)
        black = copy.deepcopy(self.recording.frames[0]['image'])
        black.data = bytes(len(black.data))
        states = []
        for i in range(10, 40):  # two seconds
            status = self.send(i, image=black)
            states.append(status.state_name)
            self.assertIn('hardly any edges', status.problem)
        self.assertEqual(states[0], 'degraded')
        self.assertEqual(states[-1], 'lost')
        widened = self.statuses['plain'][self.stamp(39).to_nsec()]
        before = self.statuses['plain'][self.stamp(9).to_nsec()]
        self.assertGreater(widened.position_std, 1.5 * before.position_std)
        self.track(40, 50)

    def test_clock_jumps_back(self):
        self.begin()
        self.track(0, 20)
        # The recording again, at its own times, without a new initial pose.
        Faults.now += 10
        for ns in NAMESPACES:
            self.statuses[ns].clear()
        self.start += 0.0
        time.sleep(0.1)
        for i in range(0, 12):
            status = self.send(i, tf=False)
            if i == 0:
                self.assertIn('jumped back', status.problem)
        self.assertEqual(status.state_name, 'tracking', status.problem)
        metres, degrees = self.error(11)
        self.assertLess(metres, 0.05)
        self.assertLess(degrees, 1.5)

    def test_image_out_of_order(self):
        self.begin()
        self.track(0, 10)
        with self.changed:
            self.statuses['plain'].pop(self.stamp(5).to_nsec())
        status = self.send(5, tf=False)
        self.assertIn('older', status.problem)
        self.track(10, 15)

    def test_late_transform(self):
        self.begin()
        self.track(0, 8)
        status = self.send(8, tf=False)  # awaited, then done without
        self.assertIn('no odometry', status.problem)
        # It comes while the image waits for it.
        timer = threading.Timer(0.05, lambda: self.send_tf(9))
        timer.start()
        status = self.send(9, tf=False)
        timer.join()
        self.assertNotIn('no odometry', status.problem)
        self.track(10, 20)

    def test_nan_in_odometry(self):
        self.begin()
        self.track(0, 8)

        def spoil(transform):
            transform.translation.x = float('nan')
        self.send_tf(8, spoil)
        status = self.send(8, tf=False)
        self.assertIn('no odometry', status.problem)
        self.track(9, 20)

    def test_nan_and_broken_initial_pose(self):
        self.begin()
        self.track(0, 8)
        for field in ('position', 'covariance', 'orientation'):
            pose = copy.deepcopy(self.recording.initial_pose)
            if field == 'position':
                pose.pose.pose.position.x = float('nan')
            elif field == 'covariance':
                pose.pose.covariance = [float('nan')] * 36
            else:
                pose.pose.pose.orientation.w = 5
            self.publishers['plain', 'initialpose'].publish(pose)
            answer = rospy.ServiceProxy('/plain/localizer/set_pose', SetPose)(pose)
            self.assertFalse(answer.success)
            self.assertIn('initial pose', answer.message)
        self.track(8, 12)

    def test_initial_pose_in_another_frame(self):
        self.begin()
        self.track(0, 8)
        unknown = copy.deepcopy(self.recording.initial_pose)
        unknown.header.frame_id = 'nowhere'
        answer = rospy.ServiceProxy('/plain/localizer/set_pose', SetPose)(unknown)
        self.assertFalse(answer.success)
        self.assertIn('nowhere', answer.message)
        # A frame that stands 5 m beside the map's: the same place has another x there.
        message = copy.deepcopy(self.recording.mounting)
        transform = message.transforms[0]
        transform.header.frame_id, transform.child_frame_id = 'map', 'beside'
        transform.transform.translation.x, transform.transform.translation.y = 5.0, 0.0
        transform.transform.translation.z = 0.0
        r = transform.transform.rotation
        r.x, r.y, r.z, r.w = 0.0, 0.0, 0.0, 1.0
        self.tf_static.publish(message)
        pose = copy.deepcopy(self.recording.initial_pose)
        pose.header.frame_id = 'beside'
        pose.pose.pose.position.x -= 5.0
        self.begin()
        service = rospy.ServiceProxy('/plain/localizer/set_pose', SetPose)
        self.assertTrue(self.wait(lambda: service(pose).success))
        self.track(0, 8)

    def test_no_camera_info(self):
        # Nothing came for this one so far: tests are run in the order of their names.
        self.begin('unmasked')
        status = self.send(0, 'unmasked', info=False)
        if 'no camera_info' not in status.problem:
            self.skipTest('another test came first')
        self.assertIn(status.state_name, ('converging', 'degraded'))
        self.track(1, 10, 'unmasked', mask=self.recording.frames[0]['mask'])

    def test_camera_info_of_another_size(self):
        self.begin()
        self.track(0, 8)
        info = copy.deepcopy(self.recording.frames[0]['info'])
        info.width, info.height = 640, 480
        status = self.send(8, info=info)
        self.assertIn('640x480', status.problem)
        self.assertEqual(status.state_name, 'degraded')
        self.track(9, 14)

    def test_truncated_image_and_odd_encoding(self):
        self.begin()
        self.track(0, 8)
        short = copy.deepcopy(self.recording.frames[8]['image'])
        short.data = short.data[:1000]
        self.assertIn('truncated', self.send(8, image=short).problem)
        odd = copy.deepcopy(self.recording.frames[9]['image'])
        odd.encoding = 'smell'
        self.assertIn('smell', self.send(9, image=odd).problem)
        self.track(10, 15)

    def test_mask_of_wrong_size_or_kind(self):
        frames = self.recording.frames
        self.begin('skip_update')
        self.track(0, 8, 'skip_update', mask=frames[0]['mask'])
        small = copy.deepcopy(frames[8]['mask'])
        small.width, small.step = 160, 160
        small.data = small.data[:160 * small.height]
        status = self.send(8, 'skip_update', mask=small)
        self.assertIn('mask', status.problem)
        self.assertEqual(status.state_name, 'degraded')
        status = self.send(9, 'skip_update', mask=frames[9]['image'])
        self.assertIn('mono8', status.problem)
        self.track(10, 15, 'skip_update', mask=frames[10]['mask'])

    def test_mask_over_everything(self):
        frames = self.recording.frames
        self.begin('skip_update')
        self.track(0, 8, 'skip_update', mask=frames[0]['mask'])
        full = copy.deepcopy(frames[8]['mask'])
        full.data = b'\xff' * len(full.data)
        status = self.send(8, 'skip_update', mask=full)
        self.assertEqual(status.state_name, 'degraded')
        self.assertAlmostEqual(status.masked_share, 1)
        self.assertIn('too little', status.problem)
        self.track(9, 15, 'skip_update', mask=frames[9]['mask'])

    def test_masks_never_come_skip_update(self):
        self.begin('skip_update')
        for i in range(3):
            status = self.send(i, 'skip_update')
            self.assertIn('no mask in time', status.problem)
            self.assertEqual(status.update_ms < 1e4, True)
        self.assertNotEqual(status.state_name, 'tracking')

    def test_masks_never_come_use_last(self):
        frames = self.recording.frames
        self.begin('use_last')
        self.track(0, 8, 'use_last', mask=frames[0]['mask'])
        status = self.send(8, 'use_last')
        self.assertAlmostEqual(status.mask_age, 1 / 15, places=3)
        self.assertGreater(status.masked_share, 0)
        self.track(9, 12, 'use_last')

    def test_masks_never_come_unmasked(self):
        self.begin('unmasked')
        status = self.track(0, 10, 'unmasked')
        self.assertEqual(status.mask_age, -1)
        self.assertEqual(status.masked_share, 0)

    def test_reload_model(self):
        self.begin()
        self.track(0, 8)
        reload_model = rospy.ServiceProxy('/plain/localizer/reload_model', UseFile)
        broken = os.path.join(self.folder.name, 'broken.obj')
        with open(broken, 'w') as f:
            f.write('v 0 0 zero\nf 1 2 3\n')
        empty = os.path.join(self.folder.name, 'empty.obj')
        open(empty, 'w').close()
        for file in (broken, empty, '/nowhere/model.obj'):
            answer = reload_model(file)
            self.assertFalse(answer.success)
            self.assertIn('is kept', answer.message)
        self.track(8, 12)
        answer = reload_model('')
        self.assertTrue(answer.success, answer.message)
        self.track(12, 18)

    def test_particles_are_saved_and_loaded(self):
        self.begin()
        self.track(0, 10)
        file = os.path.join(self.folder.name, 'particles.txt')
        save = rospy.ServiceProxy('/plain/localizer/save_particles', UseFile)
        load = rospy.ServiceProxy('/plain/localizer/load_particles', UseFile)
        answer = save(file)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.message, '300 particles')
        self.assertFalse(save('/nowhere/particles.txt').success)
        answer = load('/nowhere/particles.txt')
        self.assertFalse(answer.success)
        with open(file) as f:
            lines = f.readlines()
        with open(file + '.broken', 'w') as f:
            f.writelines(lines[:5] + ['1 2 nonsense\n'])
        answer = load(file + '.broken')
        self.assertFalse(answer.success)
        self.assertIn('line 6', answer.message)
        self.assertTrue(load(file).success)
        self.track(10, 15)

    def test_request_nomotion_update(self):
        rospy.ServiceProxy('/plain/request_nomotion_update', Empty)()

    def test_the_pose_is_stored(self):
        self.begin()
        self.track(0, 10)
        x = self.recording.frames[9]['truth'].pose.position.x
        self.assertTrue(self.wait(
            lambda: abs(rospy.get_param('/plain/localizer/initial_pose_x', 99) - x) < 0.05))


if __name__ == '__main__':
    rospy.init_node('faults_test')
    rostest.rosrun('edge_mcl', 'faults', Faults, sys.argv)
