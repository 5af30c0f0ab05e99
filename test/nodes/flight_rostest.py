#!/usr/bin/python3
"""The localizer tracks a simulated flight. Checks pose, tf, cloud, status, model and odometry."""
import math
import sys
import threading
import unittest

import rospy
import rostest
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from edge_mcl.msg import Status
from geometry_msgs.msg import PoseArray, PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, Imu
from visualization_msgs.msg import Marker


def difference(a, b):
    """Metres and degrees between two geometry_msgs/Pose."""
    metres = math.dist((a.position.x, a.position.y, a.position.z),
                       (b.position.x, b.position.y, b.position.z))
    dot = abs(sum(getattr(a.orientation, k) * getattr(b.orientation, k) for k in 'xyzw'))
    return metres, math.degrees(2 * math.acos(min(1.0, dot)))


class Flight(unittest.TestCase):
    def test_follows(self):
        lock = threading.Lock()
        got = {}

        def keep(name, key=lambda m: m.header.stamp.to_nsec()):
            def callback(message):
                with lock:
                    got.setdefault(name, {})[key(message)] = message
            return callback

        tf_buffer = tf2_ros.Buffer(rospy.Duration(100))
        listener = tf2_ros.TransformListener(tf_buffer)
        subscribers = [
            rospy.Subscriber('pose', PoseWithCovarianceStamped, keep('pose')),
            rospy.Subscriber('ground_truth', PoseStamped, keep('truth')),
            rospy.Subscriber('particlecloud', PoseArray, keep('cloud')),
            rospy.Subscriber('localizer/status', Status, keep('status')),
            rospy.Subscriber('localizer/model', Marker, keep('model', lambda m: 0)),
            rospy.Subscriber('localizer/overlay', Image, keep('overlay')),
            rospy.Subscriber('odometry/filtered', Odometry, keep('odometry')),
            rospy.Subscriber('imu/data', Imu, keep('imu')),
            rospy.Subscriber('/diagnostics', DiagnosticArray, keep('diagnostics')),
        ]
        end = rospy.Time(5)  # the flight lasts from 1 s to 5 s
        rate = threading.Event()
        for _ in range(1200):
            rate.wait(0.1)
            if rospy.Time.now() >= end - rospy.Duration(0.2):
                break
        rate.wait(1.5)
        with lock:
            common = sorted(set(got.get('pose', {})) & set(got.get('truth', {})))
            self.assertGreater(len(common), 20, 'hardly any poses: %s' % {k: len(v) for k, v in got.items()})
            errors = [difference(got['pose'][t].pose.pose, got['truth'][t].pose)
                      for t in common if t > 2e9]
            # The start has an error of 10 cm and 3 degrees, and the filter has one second to converge. The
            # limits after it are the required ones.
            self.assertLess(max(e[0] for e in errors), 0.05)
            self.assertLess(max(e[1] for e in errors), 1.5)
            # tf must give the same pose: map -> odom -> base_link.
            found = 0
            for t in common:
                stamp = rospy.Time(nsecs=t)
                try:
                    transform = tf_buffer.lookup_transform('map', 'base_link', stamp).transform
                except tf2_ros.TransformException:
                    continue
                found += 1
                if t > 2.5e9:
                    truth = got['truth'][t].pose.position
                    self.assertLess(math.dist(
                        (transform.translation.x, transform.translation.y, transform.translation.z),
                        (truth.x, truth.y, truth.z)), 0.08)
            self.assertGreater(found, 10)
            states = [s.state_name for _, s in sorted(got['status'].items())]
            self.assertEqual(states[-1], 'tracking', states)
            self.assertNotIn('lost', states)
            last = got['status'][max(got['status'])]
            self.assertGreater(last.effective_sample_size, 1)
            self.assertGreater(last.evidence, 5)
            self.assertAlmostEqual(last.mask_age, 0, places=3)
            self.assertGreater(last.masked_share, 0)
            cloud = got['cloud'][max(got['cloud'])]
            self.assertEqual(cloud.header.frame_id, 'map')
            self.assertEqual(len(cloud.poses), 500)
            self.assertGreater(len(got['model'][0].points), 500)
            self.assertEqual(got['overlay'][max(got['overlay'])].width, 320)
            self.assertTrue(got['odometry'])
            self.assertTrue(got['diagnostics'])
            # In gentle flight an IMU measures gravity, on average along its z axis.
            up = [m.linear_acceleration.z for m in got['imu'].values()]
            self.assertAlmostEqual(sum(up) / len(up), 9.81, delta=0.3)
        del subscribers, listener


if __name__ == '__main__':
    rospy.init_node('flight_test')
    rostest.rosrun('edge_mcl', 'flight', Flight, sys.argv)
