#!/usr/bin/python3
"""A bag is written by the simulator, read directly, and played through the node. A node that cannot
begin ends with one line."""
import json
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
from geometry_msgs.msg import PoseWithCovarianceStamped
from rosgraph_msgs.msg import Clock

from ending_node import check_ends_with_one_line

TOOL = os.environ['EDGE_MCL_TOOL']
FLIGHT = os.path.join(os.environ['EDGE_MCL_TEST_DATA'], 'small_flight.yaml')
MODEL = os.path.join(os.environ['EDGE_MCL_MAPS'], 'office.obj')


def tool(*arguments, status=0):
    """Runs edge-mcl. Returns its output."""
    run = subprocess.run([TOOL] + list(arguments), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                         universal_newlines=True, timeout=120)
    assert run.returncode == status, '%s: exit %d\n%s' % (arguments, run.returncode, run.stdout)
    return run.stdout


def read_trajectory(file):
    with open(file) as f:
        rows = [line.split() for line in f if not line.startswith('#')]
    return {round(float(r[0]), 4): [float(x) for x in r[1:]] for r in rows}


class Playback(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.bag = self.path('flight.bag')

    def tearDown(self):
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def test_bag_and_directory_hold_the_same_images(self):
        tool('simulate', FLIGHT, self.bag, '--images', '5')
        tool('simulate', FLIGHT, self.path('flight'), '--images', '5')
        tool('bag', self.path('flight'), self.path('copy.bag'))

        def pixels(file):
            with rosbag.Bag(file) as bag:
                return {(topic, m.header.stamp.to_nsec()): (m.encoding, m.width, m.height, bytes(m.data))
                        for topic, m, _ in bag.read_messages() if m._type == 'sensor_msgs/Image'}
        flown, copied = pixels(self.bag), pixels(self.path('copy.bag'))
        self.assertEqual(len(flown), 15)  # colour, depth, mask
        self.assertEqual(flown, copied)

    def test_played_and_read_directly(self):
        tool('simulate', FLIGHT, self.bag)
        for name in ('first.txt', 'second.txt'):
            tool('localize', self.bag, '--model', MODEL, '--depth', '--particles', '500', '--out',
                 self.path(name))
        with open(self.path('first.txt')) as a, open(self.path('second.txt')) as b:
            self.assertEqual(a.read(), b.read())
        # The bag has odometry as messages, but not in tf.
        with rosbag.Bag(self.bag) as bag, rosbag.Bag(self.path('no_tf.bag'), 'w') as without:
            for topic, message, stamp in bag.read_messages():
                if topic != '/tf':
                    without.write(topic, message, stamp)
        localize = ['localize', self.path('no_tf.bag'), '--model', MODEL, '--depth', '--particles', '500',
                    '--out', self.path('no_tf.txt')]
        self.assertNotIn('no odometry', tool(*localize))
        with open(self.path('first.txt')) as a, open(self.path('no_tf.txt')) as b:
            self.assertEqual(a.read(), b.read())
        self.assertIn('no odometry', tool(*localize, '--topics', 'odometry='))
        direct = read_trajectory(self.path('first.txt'))
        self.assertEqual(len(direct), 61)

        played, changed = {}, threading.Condition()

        def keep(message):
            with changed:
                played[round(message.header.stamp.to_sec(), 4)] = message.pose.pose.position
                changed.notify_all()
        subscriber = rospy.Subscriber('/pose', PoseWithCovarianceStamped, keep)
        publishers = {}
        # Plays the bag and waits for the answer to every image, so that a busy machine drops none.
        clock = rospy.Publisher('/clock', Clock, queue_size=10)
        with rosbag.Bag(self.bag) as bag:
            messages = list(bag.read_messages(topics=[
                '/tf', '/tf_static', '/initialpose', '/camera/mask', '/camera/camera_info',
                '/camera/depth/image_raw', '/camera/depth/camera_info', '/camera/image_raw']))
        for topic, message, _ in messages:
            if topic not in publishers:
                publishers[topic] = rospy.Publisher(topic, message.__class__, queue_size=10,
                                                    latch=topic in ('/tf_static', '/initialpose'))
        for topic, publisher in publishers.items():
            until = time.time() + 20
            while publisher.get_num_connections() == 0 and time.time() < until:
                time.sleep(0.02)
        for topic, message, stamp in messages:
            clock.publish(Clock(stamp))
            publishers[topic].publish(message)
            if topic in ('/tf_static', '/initialpose'):
                time.sleep(0.5)
            if topic == '/camera/image_raw':
                time.sleep(0.01)
                key = round(stamp.to_sec(), 4)
                with changed:
                    self.assertTrue(changed.wait_for(lambda: key in played, 20), 'no pose %.3f' % key)
        apart = [math.dist(direct[t][:3], (p.x, p.y, p.z)) for t, p in played.items()]
        self.assertEqual(len(apart), 61)
        self.assertLess(max(apart), 1e-6)
        del subscriber

    def test_depth_is_a_cue(self):
        tool('simulate', FLIGHT, self.bag)
        with rosbag.Bag(self.bag) as bag:
            truth = {round(m.header.stamp.to_sec(), 4): m.pose.position
                     for _, m, _ in bag.read_messages(topics='/ground_truth')}
        for options in (['--depth'], ['--set', 'likelihood.cues=depth']):
            stats = self.path('stats.json')
            tool('localize', self.bag, '--model', MODEL, '--particles', '500', '--out',
                 self.path('depth.txt'), '--stats', stats, *options)
            with open(stats) as f:
                images = json.load(f)['images']
            self.assertGreater(min(i['depth_points'] for i in images), 300)
            # Depth under the masks is not used. The person there is not in the model.
            self.assertGreater(min(i['depth_agreement'] for i in images[15:]), 0.6)
            errors = [math.dist(p[:3], (truth[t].x, truth[t].y, truth[t].z))
                      for t, p in sorted(read_trajectory(self.path('depth.txt')).items())]
            self.assertLess(max(errors[15:]), 0.05)
        self.assertIn('depth', tool('localize', self.bag, '--model', MODEL, '--topics',
                                    'depht=/x', status=2))

    def test_direct_reading_says_what_is_wrong(self):
        tool('simulate', FLIGHT, self.bag, '--images', '5')
        out = tool('localize', self.bag, '--model', MODEL, '--topics', 'image=/nothing', status=3)
        self.assertIn('/camera/image_raw', out)
        out = tool('localize', self.bag, '--model', MODEL, '--topics', 'pictures=/x', status=2)
        self.assertIn('image, camera_info', out)
        self.assertIn('--model', tool('localize', self.bag, status=3))
        with open(self.path('no.bag'), 'w') as f:
            f.write('this is no bag')
        tool('localize', self.path('no.bag'), '--model', MODEL, status=3)
        with open(self.bag, 'rb') as f:
            half = f.read()[:200000]
        with open(self.path('half.bag'), 'wb') as f:
            f.write(half)
        tool('localize', self.path('half.bag'), '--model', MODEL, status=3)
        self.assertIn('exists already', tool('simulate', FLIGHT, self.bag, status=3))

    def test_a_launch_file_leaves_to_the_config_what_is_not_given(self):
        config = self.path('config.yaml')
        with open(config, 'w') as f:
            f.write('use_masks: true\nodometry: none\nlikelihood: {cues: both}\nfilter: {particles: 77}\n')

        def parameters(*arguments):
            run = subprocess.run(['roslaunch', '--dump-params', 'edge_mcl', 'localizer.launch',
                                  'model:=x.obj', 'config:=' + config] + list(arguments), check=True,
                                 stdout=subprocess.PIPE, universal_newlines=True, timeout=30)
            return {line.split(': ')[0].split('/', 2)[2]: line.split(': ')[1]
                    for line in run.stdout.splitlines() if line.startswith('/edge_mcl_localizer/')}
        self.assertEqual(parameters(), {'model_file': 'x.obj', 'use_masks': 'true', 'odometry': 'none',
                                        'likelihood/cues': 'both', 'filter/particles': '77'})
        given = parameters('cues:=depth', 'particles:=5', 'use_masks:=false', 'odometry:=tf')
        self.assertEqual(given, {'model_file': 'x.obj', 'use_masks': 'false', 'odometry': 'tf',
                                 'likelihood/cues': 'depth', 'filter/particles': '5'})

    def test_the_node_ends_with_one_line(self):
        empty = self.path('empty.obj')
        open(empty, 'w').close()
        for parameters, status, text in (
                (['_model_file:=' + empty], 3, 'empty.obj'),
                (['_model_file:=/nowhere/model.obj'], 3, '/nowhere/model.obj'),
                (['_particles:=5'], 2, 'model_file is not set'),
                (['_model_file:=' + MODEL, '_filter/particels:=10'], 2, "nearest: '~filter/particles'"),
                (['_model_file:=' + MODEL, '_filter/particles:=0', '_mask_timeout:=-1'], 2, 'mask_timeout'),
                (['_model_file:=' + MODEL, '_odometry:=wheels'], 2, 'wheels')):
            check_ends_with_one_line(self, 'edge_mcl_localizer', parameters, status, text)


if __name__ == '__main__':
    rospy.init_node('playback_test')
    rostest.rosrun('edge_mcl', 'playback', Playback, sys.argv)
