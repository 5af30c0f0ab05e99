#!/usr/bin/python3
"""Depth images: with colour images and alone, registered or in their own frame, and broken ones."""
import array
import copy
import sys
import time

import numpy
import rospy
import rostest
from edge_mcl.msg import DetectedObject, DetectedObjects, ForeignObjects
from geometry_msgs.msg import Quaternion
from sensor_msgs.msg import Imu
from visualization_msgs.msg import MarkerArray

from fed_localizer import FedLocalizer


class Depth(FedLocalizer):
    namespaces = ['both', 'depth_only', 'objects']
    awaited = ('depth',)

    def depth(self, i):
        return self.recording.frames[i]['depth']

    def follow(self, first, last, ns, **more):
        for i in range(first, last):
            status = self.send(i, ns, **{'depth': self.depth(i), **more})
        metres, degrees = self.error(last - 1, ns)
        self.assertEqual(status.state_name, 'tracking', status)
        self.assertLess(metres, 0.05)
        self.assertLess(degrees, 1.5)
        self.assertGreater(status.depth_points, 300)
        self.assertGreater(status.depth_agreement, 0.6)
        return status

    def test_both(self):
        self.begin('both')
        status = self.follow(0, 12, 'both')
        self.assertGreater(status.visible_lines, 5)
        # Without depth images, the edges are enough.
        for i in range(12, 16):
            status = self.send(i, 'both')
            self.assertEqual(status.state_name, 'tracking')
            self.assertEqual(status.depth_points, 0)
            self.assertIn('no depth image in time', status.problem)
        # In the dark, depth images are enough.
        black = copy.deepcopy(self.recording.frames[0]['image'])
        black.data = bytes(len(black.data))
        for i in range(16, 30):
            status = self.send(i, 'both', image=black, depth=self.depth(i))
            self.assertEqual(status.visible_lines, 0)
            if i > 16:  # after some images without depth, the first one is not awaited
                self.assertEqual(status.state_name, 'tracking', status)
        self.assertLess(self.error(29, 'both')[0], 0.05)
        self.follow(30, 40, 'both')

    def test_depth_alone_needs_no_image(self):
        self.begin('depth_only')
        status = self.follow(0, 15, 'depth_only')
        self.assertEqual(status.visible_lines, 0)

    def test_millimetres_and_a_frame_of_its_own(self):
        # tf knows the same camera under another name.
        mounting = copy.deepcopy(self.recording.mounting)
        renamed = copy.deepcopy(mounting.transforms[0])
        renamed.child_frame_id = 'depth_optical'
        mounting.transforms.append(renamed)
        self.tf_static.publish(mounting)
        self.begin('both')
        for i in range(12):
            message = copy.deepcopy(self.depth(i))
            self.assertEqual(message.encoding, '32FC1')
            metres = array.array('f', bytes(message.data))
            message.data = array.array('H', [round(1000 * m) if m > 0 else 0 for m in metres]).tobytes()
            message.encoding = '16UC1'
            message.step //= 2
            message.header.frame_id = 'depth_optical'
            status = self.send(i, 'both', depth=message)
        self.assertEqual(status.state_name, 'tracking', status)
        self.assertGreater(status.depth_agreement, 0.6)

    def test_imu(self):
        imu = rospy.Publisher('/both/imu', Imu, queue_size=10)
        self.assertTrue(self.wait(lambda: imu.get_num_connections() > 0))

        def reading(i):
            message = Imu()
            message.header.stamp = self.stamp(i)
            message.header.frame_id = 'base_link'
            message.orientation = copy.deepcopy(self.recording.frames[i]['truth'].pose.orientation)
            return message
        self.begin('both')
        for i in range(8):
            imu.publish(reading(i))
            time.sleep(0.02)
            status = self.send(i, 'both', depth=self.depth(i))
        self.assertEqual(status.state_name, 'tracking', status)
        self.assertNotIn('imu', status.problem)
        self.assertLess(self.error(7, 'both')[1], 1.0)
        # An orientation that lies on its side is not used and is reported.
        wrong = reading(8)
        wrong.orientation = Quaternion(0.7071068, 0, 0, 0.7071068)
        without = reading(9)
        without.orientation_covariance[0] = -1
        broken = reading(10)
        broken.orientation.x = float('nan')
        for i, message, text in ((8, wrong, 'contradict'), (9, without, 'no orientation'),
                                 (10, broken, 'imu'), (11, None, 'no imu message')):
            if message:
                imu.publish(message)
                time.sleep(0.02)
            status = self.send(i, 'both', depth=self.depth(i))
            self.assertIn(text, status.problem)
            self.assertEqual(status.state_name, 'tracking', status)

    def test_objects_that_are_not_in_the_model(self):
        lists, markers, texts = [], [], set()
        keep = [rospy.Subscriber('/objects/foreign_objects', ForeignObjects, lists.append),
                rospy.Subscriber('/objects/localizer/foreign_object_markers', MarkerArray, markers.append)]
        detections = rospy.Publisher('/objects/detections', DetectedObjects, queue_size=20)
        self.assertTrue(self.wait(lambda: detections.get_num_connections() > 0))
        self.assertTrue(self.wait(lambda: all(s.get_num_connections() > 0 for s in keep)))
        self.begin('objects')
        for i in range(len(self.recording.frames)):
            self.send(i, 'objects', depth=self.depth(i))
            # The detector sees what the simulator's mask holds: a person.
            mask = self.recording.frames[i]['mask']
            rows, columns = numpy.nonzero(numpy.frombuffer(mask.data, numpy.uint8).reshape(mask.height, mask.step))
            if len(rows) < 2000:
                continue
            found = DetectedObject(class_name='person', score=0.8, x=columns.min(), y=rows.min(),
                                   width=numpy.ptp(columns), height=numpy.ptp(rows))
            message = DetectedObjects(objects=[found])
            message.header.stamp = self.stamp(i)
            detections.publish(message)
        self.assertTrue(self.wait(lambda: lists and lists[-1].objects))
        people = [o for o in lists[-1].objects if o.class_name == 'person']
        self.assertEqual(len(people), 1, lists[-1])
        self.assertEqual(lists[-1].header.frame_id, 'map')
        self.assertEqual(len({o.number for m in lists for o in m.objects}), len(lists[-1].objects))
        self.assertGreater(people[0].size.z, 0.8)
        self.assertLess(max(people[0].size.x, people[0].size.y), 1.0)
        for message in markers:
            texts |= {m.text for m in message.markers if m.text}
        self.assertIn('%d person' % people[0].number, texts)

    def test_broken_depth_is_named_and_left_out(self):
        self.begin('both')
        self.follow(0, 8, 'both')
        odd = copy.deepcopy(self.depth(8))
        odd.encoding = 'mono8'
        short = copy.deepcopy(self.depth(9))
        short.data = short.data[:1000]
        small = copy.deepcopy(self.depth(10))
        small.height //= 2
        small.data = small.data[:len(small.data) // 2]
        elsewhere = copy.deepcopy(self.depth(11))
        elsewhere.header.frame_id = 'nobody_knows'
        covered = copy.deepcopy(self.depth(12))
        covered.data = bytes(len(covered.data))
        for i, (depth, text) in enumerate(((odd, 'depth'), (short, 'depth'), (small, 'depth'),
                                           (elsewhere, 'nobody_knows'), (covered, 'covered?'))):
            status = self.send(8 + i, 'both', depth=depth)
            self.assertIn(text, status.problem)
            self.assertEqual(status.state_name, 'tracking', status)  # with the edges alone
            self.assertEqual(status.depth_points, 0)
        self.follow(13, 20, 'both')


if __name__ == '__main__':
    rospy.init_node('depth_test')
    rostest.rosrun('edge_mcl', 'depth', Depth, sys.argv)
