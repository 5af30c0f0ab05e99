#!/usr/bin/python3
"""The bridge to MAVROS. The test plays the localizer: it knows which poses are right, and which are not."""
import threading
import time
import unittest

import rospy
import rostest
from edge_mcl.msg import Status
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import UInt8


class Mavros(unittest.TestCase):
    def setUp(self):
        self.lock, self.poses, self.odometry, self.resets = threading.Lock(), [], [], []

        def keep(kept):
            def receive(message):
                with self.lock:
                    kept.append(message)
            return receive
        # The types are those of the plugins vision_pose and odometry of MAVROS.
        rospy.Subscriber('mavros/vision_pose/pose_cov', PoseWithCovarianceStamped, keep(self.poses))
        rospy.Subscriber('mavros/odometry/out', Odometry, keep(self.odometry))
        rospy.Subscriber('edge_mcl_mavros/reset_counter', UInt8, keep(self.resets))
        self.pose = rospy.Publisher('pose', PoseWithCovarianceStamped, queue_size=10)
        self.status = rospy.Publisher('localizer/status', Status, queue_size=10)
        self.filtered = rospy.Publisher('odometry/filtered', Odometry, queue_size=50)
        until = time.time() + 15
        while time.time() < until and not all(p.get_num_connections() for p in (self.pose, self.status, self.filtered)):
            time.sleep(0.05)

    def image(self, stamp, x, probability=0.95, state=Status.TRACKING):
        pose, status = PoseWithCovarianceStamped(), Status()
        pose.header.stamp = status.header.stamp = stamp
        pose.header.frame_id = 'map'
        pose.pose.pose.position.x, pose.pose.pose.orientation.w = x, 1
        pose.pose.covariance[0] = 0.01
        status.state, status.probability = state, probability
        self.pose.publish(pose)
        time.sleep(0.005)  # two topics have no common order
        self.status.publish(status)

    def test_only_sure_poses_are_passed_on(self):
        begin = rospy.Time.now()
        for i in range(60):  # 6 s at 10 Hz; from image 20 to 39 the pose is wrong and the localizer unsure
            wrong = 20 <= i < 40
            self.image(begin + rospy.Duration(0.1 * i), 7.0 if wrong else 0.01 * i, 0.3 if wrong else 0.95,
                       Status.DEGRADED if wrong else Status.TRACKING)
            time.sleep(0.02)
        time.sleep(0.5)
        with self.lock:
            # Of 20 sure images three are withheld each time, or four when rounded stamps are just short of 0.3 s.
            self.assertIn(len(self.poses), (32, 33, 34))
            self.assertTrue(all(p.pose.pose.position.x < 1 for p in self.poses))
            self.assertTrue(all(p.header.frame_id == 'map' and p.pose.covariance[0] == 0.01 for p in self.poses))
            self.assertEqual([r.data for r in self.resets], [0, 1, 2])
            del self.poses[:]

        # With odometry between the images, poses come at up to 30 Hz, and with odometry for MAVROS as well.
        begin = rospy.Time.now() + rospy.Duration(100)
        for i in range(200):  # 2 s at 100 Hz, an image at every tenth
            stamp = begin + rospy.Duration(0.01 * i)
            if i % 10 == 0:
                self.image(stamp, 0.001 * i)
            odometry = Odometry()
            odometry.header.stamp, odometry.header.frame_id, odometry.child_frame_id = stamp, 'map', 'base_link'
            odometry.pose.pose.orientation.w, odometry.pose.pose.position.x = 1, 0.001 * i
            self.filtered.publish(odometry)
            time.sleep(0.01)
        time.sleep(0.5)
        with self.lock:
            stamps = [p.header.stamp.to_sec() for p in self.poses]
            gaps = sorted(b - a for a, b in zip(stamps, stamps[1:]))
            # The first 0.3 s are withheld; 1.7 s at 25 to 33 Hz remain (a step of 10 ms in 30 Hz), less what was late.
            self.assertGreater(len(stamps), 35)
            self.assertLess(len(stamps), 58)
            self.assertGreater(gaps[0], 0.029)
            self.assertEqual(len(self.odometry), len(stamps))
            self.assertEqual({o.child_frame_id for o in self.odometry}, {'base_link'})


if __name__ == '__main__':
    rospy.init_node('mavros_rostest')
    rostest.rosrun('edge_mcl', 'mavros', Mavros)
