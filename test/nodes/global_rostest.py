#!/usr/bin/python3
"""The localizer finds the robot in the whole building, and searches again when a service asks for it."""
import math
import sys
import threading
import unittest

import rospy
import rostest
from edge_mcl.msg import Status
from geometry_msgs.msg import PoseArray, PoseStamped, PoseWithCovarianceStamped
from sensor_msgs.msg import Imu
from std_srvs.srv import Empty


class Global(unittest.TestCase):
    def test_finds_itself(self):
        lock = threading.Lock()
        got = {'pose': {}, 'truth': {}, 'status': [], 'hypotheses': []}

        def keep(name):
            def callback(message):
                with lock:
                    if isinstance(got[name], dict):
                        got[name][message.header.stamp.to_nsec()] = message
                    else:
                        got[name].append(message)
            return callback

        subscribers = [
            rospy.Subscriber('pose', PoseWithCovarianceStamped, keep('pose')),
            rospy.Subscriber('ground_truth', PoseStamped, keep('truth')),
            rospy.Subscriber('localizer/status', Status, keep('status')),
            rospy.Subscriber('hypotheses', PoseArray, keep('hypotheses')),
        ]

        # The IMU of the simulator gives no orientation. This message acts as an attitude sensor.
        imu = rospy.Publisher('imu', Imu, queue_size=50)

        def level(truth):
            message = Imu()
            message.header.stamp = truth.header.stamp
            message.header.frame_id = 'base_link'
            message.orientation = truth.pose.orientation
            imu.publish(message)

        subscribers.append(rospy.Subscriber('ground_truth', PoseStamped, level))

        def wait(what, seconds):
            for _ in range(int(10 * seconds)):
                with lock:
                    if what():
                        return True
                threading.Event().wait(0.1)
            return False

        self.assertTrue(wait(lambda: any(s.state == Status.SEARCHING for s in got['status']), 60))
        with lock:
            self.assertFalse(got['pose'], 'a pose although nobody knows where it is')
        self.assertTrue(wait(lambda: any(s.state == Status.TRACKING for s in got['status']), 90),
                        [(s.state_name, s.problem, s.search_keyframes) for s in got['status']][-5:])
        wait(lambda: len(set(got['pose']) & set(got['truth'])) > 3, 10)
        with lock:
            common = sorted(set(got['pose']) & set(got['truth']))
            self.assertTrue(common)
            a, b = got['pose'][common[-1]].pose.pose.position, got['truth'][common[-1]].pose.position
            self.assertLess(math.dist((a.x, a.y, a.z), (b.x, b.y, b.z)), 0.1)
            self.assertTrue(got['hypotheses'])
            self.assertTrue(got['hypotheses'][0].poses)
            got['status'].clear()
        rospy.ServiceProxy('global_localization', Empty)()
        self.assertTrue(wait(lambda: any(s.state == Status.SEARCHING for s in got['status']), 20))
        del subscribers


if __name__ == '__main__':
    rospy.init_node('global_test')
    rostest.rosrun('edge_mcl', 'global', Global, sys.argv)
