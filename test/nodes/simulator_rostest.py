#!/usr/bin/python3
"""The node's images equal those of the recorder and are never ahead of the clock. No key is lost."""
import os
import pty
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import rosbag
import rospy
import rostest
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image

TOOL = os.environ['EDGE_MCL_TOOL']
SCENARIO = os.path.join(os.environ['EDGE_MCL_TEST_DATA'], 'small_blur.yaml')
RATE, BEGIN, IMAGES = 15, 1.0, 16


class Simulator(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.images, cls.clock, cls.changed = {}, set(), threading.Condition()

        def keep_image(message):
            with cls.changed:
                cls.images[message.header.stamp.to_nsec()] = bytes(message.data)
                cls.changed.notify_all()

        def keep_clock(message):
            with cls.changed:
                cls.clock.add(message.clock.to_nsec())
        cls.subscribers = [rospy.Subscriber('/clock', Clock, keep_clock, queue_size=1000),
                           rospy.Subscriber('camera/image_raw', Image, keep_image)]

    def test_images_are_the_recorders_and_not_ahead_of_the_clock(self):
        last = round((BEGIN + (IMAGES - 1) / RATE) * 1e9)
        with self.changed:
            self.assertTrue(self.changed.wait_for(
                lambda: any(abs(t - last) < 1e6 for t in self.images), 60), sorted(self.images))
        time.sleep(0.5)
        with self.changed:
            images, clock = dict(self.images), set(self.clock)
        # The first images were sent before this test listened.
        heard = {t: pixels for t, pixels in images.items() if t > min(clock)}
        self.assertGreater(len(heard), 4)
        self.assertEqual([t for t in sorted(heard) if t not in clock], [])
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, 'flight.bag')
            subprocess.run([TOOL, 'simulate', SCENARIO, file], check=True, timeout=60,
                           stdout=subprocess.DEVNULL)
            with rosbag.Bag(file) as bag:
                recorded = [bytes(m.data) for _, m, _ in bag.read_messages('/camera/image_raw')]
        self.assertEqual(len(recorded), IMAGES)
        for t, pixels in heard.items():
            expected = recorded[round((t / 1e9 - BEGIN) * RATE)]
            self.assertEqual(len(pixels), len(expected))
            # Times differ in their last bit. So outlines differ in some pixels.
            apart = sum(abs(a - b) > 4 for a, b in zip(pixels, expected))
            self.assertLess(apart, 100, t)

    def test_no_key_is_lost(self):
        speeds, changed = [], threading.Condition()

        def keep(message):
            with changed:
                speeds.append(message.linear.x)
                changed.notify_all()

        def wait_for(speed):
            with changed:
                speeds.clear()
                self.assertTrue(changed.wait_for(lambda: speeds and speeds[-1] == speed, 20), speeds)
        subscriber = rospy.Subscriber('keys', Twist, keep)
        terminal, keyboard = pty.openpty()
        teleop = subprocess.Popen(
            [os.path.join(os.path.dirname(sys.argv[0]), 'edge_mcl_teleop'), 'cmd_vel:=keys'],
            stdin=keyboard, stdout=subprocess.DEVNULL)
        try:
            os.close(keyboard)
            wait_for(0.0)
            os.write(terminal, b'w')
            wait_for(0.5)
            os.write(terminal, b's ')  # both keys at once
            wait_for(0.0)
            os.close(terminal)
            self.assertEqual(teleop.wait(20), 0)
        finally:
            if teleop.poll() is None:
                teleop.kill()
                teleop.wait()
        subscriber.unregister()


if __name__ == '__main__':
    rospy.init_node('simulator_test')
    rostest.rosrun('edge_mcl', 'simulator', Simulator, sys.argv)
