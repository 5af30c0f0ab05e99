#!/usr/bin/python3
"""The simulator flies by commands and by its own clock, and publishes the right images."""
import math
import sys
import threading
import unittest

import rospy
import rostest
from geometry_msgs.msg import PoseStamped, Twist
from sensor_msgs.msg import CameraInfo, Image, Imu


class Live(unittest.TestCase):
    def test_flies(self):
        got, changed = {'truth': [], 'imu': [], 'image': [], 'mask': []}, threading.Condition()

        def keep(name):
            def callback(message):
                with changed:
                    got[name].append(message)
                    changed.notify_all()
            return callback
        subscribers = [rospy.Subscriber('ground_truth', PoseStamped, keep('truth')),
                       rospy.Subscriber('imu/data', Imu, keep('imu'), queue_size=1000),
                       rospy.Subscriber('camera/image_raw', Image, keep('image')),
                       rospy.Subscriber('camera/mask', Image, keep('mask'))]
        info = rospy.wait_for_message('camera/camera_info', CameraInfo, 30)
        self.assertEqual((info.width, info.height), (320, 240))
        commands = rospy.Publisher('cmd_vel', Twist, queue_size=1)

        def fly(velocity, turn, seconds):
            """Sends commands at 20 Hz of the simulated clock. Returns the true pose at the end."""
            twist = Twist()
            twist.linear.x, twist.linear.y, twist.linear.z = velocity
            twist.angular.z = turn
            end = rospy.Time.now() + rospy.Duration(seconds)
            while rospy.Time.now() < end:
                commands.publish(twist)
                rospy.sleep(0.05)
            with changed:
                return got['truth'][-1].pose
        with changed:
            self.assertTrue(changed.wait_for(lambda: len(got['truth']) > 3, 30))
        bad = Twist()
        bad.linear.x = float('nan')
        commands.publish(bad)
        begin = fly((0, 0, 0), 0, 0.3)
        there = fly((0.6, 0, 0), 0, 1.5)
        yaw = math.radians(35)  # heading at the first waypoint of the scenario
        forward = ((there.position.x - begin.position.x) * math.cos(yaw) +
                   (there.position.y - begin.position.y) * math.sin(yaw))
        sideways = ((there.position.y - begin.position.y) * math.cos(yaw) -
                    (there.position.x - begin.position.x) * math.sin(yaw))
        # 0.6 m/s for 1.5 s are 0.9 m. A lag of about half a second makes it less.
        self.assertGreater(forward, 0.3)
        self.assertLess(forward, 0.95)
        self.assertLess(abs(sideways), 0.05)
        # It flies towards a wall and stops in front of it.
        end = fly((2, 0, 0), 0, 4)
        self.assertTrue(0.1 < end.position.x < 5.9 and 0.1 < end.position.y < 5.9, end)
        with changed:
            self.assertGreater(len(got['image']), 10)
            self.assertEqual(len(got['image'][-1].data), 320 * 240 * 3)
            self.assertTrue(any(any(m.data) for m in got['mask']), 'the person is never seen')
            # The IMU gives 200 readings per simulated second.
            stamps = [m.header.stamp.to_sec() for m in got['imu']]
            steps = [b - a for a, b in zip(stamps, stamps[1:])]
            self.assertAlmostEqual(sorted(steps)[len(steps) // 2], 1 / 200, places=6)
        del subscribers


if __name__ == '__main__':
    rospy.init_node('live_test')
    rostest.rosrun('edge_mcl', 'live', Live, sys.argv)
