#!/usr/bin/python3
"""The viewer node shows a live system, and must not end because of missing or broken messages."""
import os
import shlex
import struct
import subprocess
import sys
import threading
import time
import unittest

import roslaunch
import rospy
import rostest
from edge_mcl.msg import DetectedObject, DetectedObjects, Status
from geometry_msgs.msg import Pose, PoseArray, PoseWithCovarianceStamped
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CameraInfo, Image

OUT = os.environ['EDGE_MCL_VIEWER_OUT']
BEGIN = time.time()


def is_new(file):
    """Whether this run made the file. Old files are not removed, because a viewer may hold one open."""
    return os.path.exists(file) and os.path.getmtime(file) >= BEGIN


def size_of_png(file):
    with open(file, 'rb') as f:
        head = f.read(24)
    return struct.unpack('>II', head[16:24])


class Viewer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.texts, cls.lock = [], threading.Lock()

        def said(message):
            with cls.lock:
                cls.texts.append((message.name, message.msg))
        cls.log = rospy.Subscriber('/rosout', Log, said)
        cls.publishers = {}
        for topic, kind in (('image', Image), ('mask', Image), ('camera_info', CameraInfo),
                            ('detections', DetectedObjects), ('pose', PoseWithCovarianceStamped),
                            ('particlecloud', PoseArray), ('status', Status)):
            cls.publishers[topic] = rospy.Publisher('/fed/' + topic, kind, queue_size=20)

    def wait(self, condition, seconds, what):
        until = time.time() + seconds
        while not condition():
            self.assertLess(time.time(), until, what + ': %s' % self.texts[-5:])
            time.sleep(0.05)

    def has_said(self, node, text):
        with self.lock:
            return any(name == node and text in said for name, said in self.texts)

    def runs(self, node):
        nodes = subprocess.run(['rosnode', 'list'], stdout=subprocess.PIPE, text=True).stdout
        return node in nodes.split()

    def send(self, topic, message, stamp):
        message.header.stamp = rospy.Time.from_sec(stamp)
        self.publishers[topic].publish(message)

    def status(self, state, stamp, problem=''):
        self.send('status', Status(state=state, state_name='', problem=problem), stamp)

    def image(self, width=64, height=48, length=None):
        m = Image(width=width, height=height, encoding='mono8', step=width)
        m.header.frame_id = 'base_link'
        m.data = bytes(width * height if length is None else length)
        return m

    def test_fed_with_what_is_missing_late_and_broken(self):
        for publisher in self.publishers.values():
            self.wait(lambda p=publisher: p.get_num_connections() > 0, 20, 'no viewer on ' + publisher.name)
        self.wait(lambda: self.has_said('/fed/fed_viewer', '/fed/status'), 20,
                  'it does not say what is missing')
        # Moment 1 has only a status, 2 an image that is cut off, 3 a camera of another size.
        self.status(Status.SEARCHING, 10.0)
        self.send('image', self.image(length=100), 10.1)
        self.status(Status.TRACKING, 10.1)
        info = CameraInfo(width=640, height=480, distortion_model='plumb_bob', D=[0.0] * 5)
        info.K = [500, 0, 320, 0, 500, 240, 0, 0, 1]
        self.send('camera_info', info, 10.2)
        time.sleep(0.2)
        self.send('image', self.image(), 10.2)
        self.status(Status.TRACKING, 10.2)
        # Moment 4 has invalid poses and particles, and an unknown state.
        pose = PoseWithCovarianceStamped()
        pose.pose.pose.position.x = float('nan')
        pose.pose.pose.orientation.w = 1
        self.send('pose', pose, 10.3)
        self.send('particlecloud', PoseArray(poses=[Pose()]), 10.3)
        self.send('detections', DetectedObjects(
            objects=[DetectedObject(class_name='x' * 300, x=-5, y=float('inf'), width=1e9)]), 10.3)
        self.send('mask', self.image(7, 5), 10.3)
        self.send('image', self.image(640, 480), 10.3)
        self.status(77, 10.3)
        time.sleep(1)
        # In moment 5 time goes back. Moment 6 is without fault.
        self.status(Status.UNINITIALIZED, 1.0)
        pose.pose.pose.position.x = 2
        self.send('pose', pose, 1.1)
        self.send('image', self.image(640, 480), 1.1)
        self.status(Status.TRACKING, 1.1)
        self.wait(lambda: is_new(OUT + '/fed-1.png'), 30, 'no picture')
        self.assertEqual(size_of_png(OUT + '/fed-1.png'), (1280, 720))
        self.wait(lambda: not self.runs('/fed/fed_viewer'), 20, 'it does not end')

    def test_shows_a_flight(self):
        self.wait(lambda: is_new(OUT + '/flight-1.png'), 90, 'no picture')
        self.assertEqual(size_of_png(OUT + '/flight-1.png'), (1280, 720))
        self.assertGreater(os.path.getsize(OUT + '/flight-1.png'), 100000)
        self.wait(lambda: not self.runs('/flight_viewer'), 20, 'it does not end')
        self.assertGreater(os.path.getsize(OUT + '/flight.mp4'), 10000)
        with self.lock:
            faults = [said for name, said in self.texts if name == '/flight_viewer' and 'nothing comes' in said]
        # Before the simulator begins, messages are really missing. Later none is.
        self.assertLess(len(faults), 5, faults)

    def test_a_localizer_may_begin_later(self):
        status = rospy.Publisher('/early/status', Status, queue_size=1)
        self.wait(lambda: status.get_num_connections() > 0, 20, 'no viewer')
        self.wait(lambda: self.has_said('/early_viewer', '/early/status'), 20,
                  'it does not say what is missing')
        rospy.set_param('/late_localizer/model_file', os.environ['EDGE_MCL_MAPS'] + '/office.obj')
        status.publish(Status(state=Status.SEARCHING))
        self.wait(lambda: self.has_said('/early_viewer', 'office.obj'), 20, 'it has no model')
        self.wait(lambda: is_new(OUT + '/early-1.png'), 30, 'no picture')

    def test_a_bag_may_have_a_space_in_its_path(self):
        file = roslaunch.rlutil.resolve_launch_arguments(['edge_mcl', 'playback.launch'])[0]
        config = roslaunch.config.load_config_default(
            [(file, ['bag:=/home/me/first hour.bag', 'model:=x.obj'])], None, verbose=False,
            assign_machines=False)
        player = [n for n in config.nodes if n.name == 'player'][0]
        self.assertEqual(shlex.split(player.args)[-1], '/home/me/first hour.bag')


if __name__ == '__main__':
    rospy.init_node('viewer_test')
    rostest.rosrun('edge_mcl', 'viewer', Viewer, sys.argv)
