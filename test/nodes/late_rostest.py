#!/usr/bin/python3
"""Messages that come late, in an unexpected order, or from another time."""
import copy
import math
import sys
import threading
import time

import rospy
import rostest
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Empty

from fed_localizer import FedLocalizer, at


class Late(FedLocalizer):
    namespaces = ['plain', 'topic', 'pair']

    def send_with_late_tf(self, i):
        timer = threading.Timer(0.04, lambda: self.send_tf(i))
        timer.start()
        status = self.send(i, tf=False)
        timer.join()
        return status

    def test_odometry_behind_its_images_is_awaited_again_after_a_silence(self):
        self.begin()
        for i in range(8):
            self.assertNotIn('no odometry', self.send_with_late_tf(i).problem)
        for i in range(8, 14):
            self.assertIn('no odometry', self.send(i, tf=False).problem)
        self.send_with_late_tf(14)  # only after this image the localizer knows that odometry comes again
        for i in range(15, 25):
            self.assertNotIn('no odometry', self.send_with_late_tf(i).problem)

    def test_a_camera_that_turns_on_the_robot(self):
        # The mounting at the time of the image counts, although a newer one has come.
        def mounting(stamp, degrees):
            message = copy.deepcopy(self.recording.mounting)
            transform = message.transforms[0]
            transform.header.stamp, transform.child_frame_id = stamp, 'gimbal'
            q = transform.transform.rotation
            c, s = math.cos(math.radians(degrees) / 2), math.sin(math.radians(degrees) / 2)
            # The camera turns about its own y axis.
            q.x, q.y, q.z, q.w = (q.x * c - q.z * s, q.y * c + q.w * s, q.z * c + q.x * s,
                                  q.w * c - q.y * s)
            return message

        self.begin()
        for i in range(12):
            self.tf.publish(mounting(self.stamp(i), 0))
            self.tf.publish(mounting(self.stamp(i) + rospy.Duration(0.05), 20))
            time.sleep(0.02)
            image = copy.deepcopy(self.recording.frames[i]['image'])
            image.header.frame_id = 'gimbal'
            status = self.send(i, image=image)
        self.assertEqual(status.state_name, 'tracking', status.problem)
        metres, degrees = self.error(11)
        self.assertLess(metres, 0.05)
        self.assertLess(degrees, 1.5)

    def odometry(self, i, stamp):
        message = Odometry()
        message.header.stamp, message.header.frame_id = stamp, 'odom'
        transform = self.recording.frames[i]['tf'].transforms[0].transform
        p, q = message.pose.pose.position, message.pose.pose.orientation
        p.x, p.y, p.z = transform.translation.x, transform.translation.y, transform.translation.z
        q.x, q.y, q.z, q.w = (getattr(transform.rotation, k) for k in 'xyzw')
        return message

    def test_odometry_on_a_topic(self):
        publisher = rospy.Publisher('/topic/odom', Odometry, queue_size=20)
        received, changed = [], threading.Condition()

        def keep(message):
            with changed:
                received.append(message)
                changed.notify_all()
        subscriber = rospy.Subscriber('/topic/odometry/filtered', Odometry, keep)
        self.assertTrue(self.wait(lambda: publisher.get_num_connections() > 0))
        self.assertTrue(self.wait(lambda: subscriber.get_num_connections() > 0))

        def fly(first, last):
            for i in range(first, last):
                publisher.publish(self.odometry(i, self.stamp(i)))
                time.sleep(0.01)
                status = self.send(i, 'topic', tf=False)
                self.assertNotIn('no odometry', status.problem)
            return status
        Late.now += 100
        self.begin('topic')
        fly(0, 15)

        # Between images odometry moves the pose. The longer it does, the larger is the covariance.
        def filtered(seconds):
            stamp = self.stamp(14) + rospy.Duration(seconds)
            publisher.publish(self.odometry(14, stamp))
            with changed:
                self.assertTrue(changed.wait_for(
                    lambda: received and received[-1].header.stamp == stamp, 10))
                return received[-1].pose.covariance[0]
        soon, later = filtered(0.1), filtered(10)
        self.assertGreater(soon, 0)
        self.assertGreater(later, 2 * soon)

        # A bag is played in a loop. Messages from before the jump belong to another time.
        self.start -= 60
        status = fly(0, 30)
        self.assertEqual(status.state_name, 'tracking', status.problem)

        # After the pose is forgotten, odometry does not move it on.
        rospy.ServiceProxy('/topic/global_localization', Empty)()
        time.sleep(0.2)
        with changed:
            received.clear()
        for k in range(5):
            publisher.publish(self.odometry(29, self.stamp(29) + rospy.Duration(0.01 * k)))
            time.sleep(0.02)
        time.sleep(0.3)
        self.assertEqual(len(received), 0)

    def test_two_cameras_of_which_one_is_late(self):
        b_image = rospy.Publisher('/pair/b/image', Image, queue_size=20)
        b_info = rospy.Publisher('/pair/b/camera_info', CameraInfo, queue_size=20)
        self.assertTrue(self.wait(lambda: b_image.get_num_connections() > 0))
        self.assertTrue(self.wait(lambda: b_info.get_num_connections() > 0))
        frames = self.recording.frames
        b_info.publish(frames[0]['info'])

        def send_b(i):
            b_image.publish(at(frames[i]['image'], self.stamp(i)))
        self.begin()
        alone = [self.send(i).visible_samples for i in range(24)]
        self.begin('pair')
        for i in range(6):
            status = self.send(i, 'pair')
            self.assertIn('b: no image of this moment', status.problem)
            self.assertLess(status.visible_samples, 1.3 * alone[i])
        for i in range(6, 14):  # late by half of the time between images, which is more than the window
            timer = threading.Timer(0.035, lambda i=i: send_b(i))
            timer.start()
            status = self.send(i, 'pair')
            timer.join()
            if i > 6:  # only after the first image the localizer knows that they come
                self.assertNotIn('no image', status.problem, 'image %d' % i)
                self.assertGreater(status.visible_samples, 1.5 * alone[i])
        for i in (14, 15):
            send_b(i)
        for i in range(14, 24):  # camera b is two images ahead
            send_b(i + 2)
            status = self.send(i, 'pair')
            self.assertNotIn('no image', status.problem, 'image %d' % i)
            self.assertGreater(status.visible_samples, 1.5 * alone[i])
        self.assertEqual(status.state_name, 'tracking')


if __name__ == '__main__':
    rospy.init_node('late_test')
    rostest.rosrun('edge_mcl', 'late', Late, sys.argv)
