#!/usr/bin/python3
"""The node waits for a depth camera, publishes its images, and survives that it is unplugged."""
import os
import sys
import threading
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import CameraInfo, Image

from ending_node import check_ends_with_one_line

PLUGGED = os.environ['EDGE_MCL_DRIVER_PLUGGED']


def plug(is_in):
    if is_in:
        open(PLUGGED, 'w').close()
    elif os.path.exists(PLUGGED):
        os.remove(PLUGGED)


plug(False)


class OpenNi2(unittest.TestCase):
    def setUp(self):
        self.changed, self.got, self.keep_alive = threading.Condition(), {}, []
        for name, topic, kind in (
                ('color', 'camera/color/image_raw', Image),
                ('depth', 'camera/depth/image_raw', Image),
                ('color_info', 'camera/color/camera_info', CameraInfo),
                ('depth_info', 'camera/depth/camera_info', CameraInfo),
                ('diagnostics', '/diagnostics', DiagnosticArray)):
            self.got[name] = []
            self.keep_alive.append(rospy.Subscriber(topic, kind, self.keep, name))

    def keep(self, message, name):
        with self.changed:
            self.got[name].append((rospy.Time.now(), message))
            self.changed.notify_all()

    def wait(self, what, condition, seconds=20):
        with self.changed:
            self.assertTrue(self.changed.wait_for(condition, seconds), what)

    def diagnosis(self):
        texts = [s.message for _, m in self.got['diagnostics'] for s in m.status
                 if 'depth camera' in s.name]
        return texts[-1] if texts else ''

    def test_the_life_of_a_camera(self):
        self.wait('no device', lambda: 'no OpenNI2 device found' in self.diagnosis())
        plug(True)
        self.wait('no images', lambda: len(self.got['color']) > 60 and len(self.got['depth']) > 60, 40)
        self.wait('not streaming', lambda: self.diagnosis() == 'streaming')
        for name, encoding in (('color', 'rgb8'), ('depth', '16UC1')):
            stamps = [m.header.stamp for _, m in self.got[name]]
            self.assertEqual(stamps, sorted(set(stamps)))
            # A frame was taken before it came, but not long before. The limit of 1 s is for a busy machine.
            ages = sorted((at - m.header.stamp).to_sec() for at, m in self.got[name])
            self.assertGreaterEqual(ages[0], 0)
            self.assertLess(ages[len(ages) // 2], 1)
            message = self.got[name][-1][1]
            self.assertEqual((message.width, message.height, message.encoding), (320, 240, encoding))
            self.assertEqual(message.header.frame_id, 'camera_color_optical_frame')
            info = self.got[name + '_info'][-1][1]
            self.assertEqual((info.K[0], info.distortion_model), (215.0, 'plumb_bob'))

        plug(False)
        self.wait('unplugged', lambda: 'unplugged' in self.diagnosis() or 'no OpenNI2' in self.diagnosis())
        count = len(self.got['color'])
        rospy.sleep(0.5)
        self.assertLess(len(self.got['color']), count + 3)
        plug(True)
        self.wait('not there again', lambda: len(self.got['color']) > count + 15)
        stamps = [m.header.stamp for _, m in self.got['color']]
        self.assertEqual(stamps, sorted(set(stamps)))

    def test_what_cannot_be_opened_ends_it_with_one_line(self):
        for parameters, status, text in (
                (['_device:=/nowhere/flight.oni'], 3, '/nowhere/flight.oni: no such recording'),
                (['_color_calibration:=/nowhere.yaml'], 3, '/nowhere.yaml'),
                (['_colour:=true'], 2, "nearest: '~color'"),
                (['_color:=false', '_depth:=false', '_retry_period:=0'], 2, 'retry_period')):
            check_ends_with_one_line(self, 'edge_mcl_openni2', parameters, status, text)


if __name__ == '__main__':
    rospy.init_node('openni2_test')
    rostest.rosrun('edge_mcl', 'openni2', OpenNi2, sys.argv)
