#!/usr/bin/python3
"""The detector answers every image. A faulty detector must not give the localizer a wrong pose."""
import copy
import sys
import threading
import time

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from edge_mcl.msg import DetectedObjects
from sensor_msgs.msg import Image

from ending_node import check_ends_with_one_line
from fed_localizer import FedLocalizer, at


def filled(image, value):
    mask = copy.deepcopy(image)
    mask.encoding, mask.step = 'mono8', image.width
    mask.data = bytes([value]) * (image.width * image.height)
    return mask


class Detector(FedLocalizer):
    namespaces = ['plain']

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.got, cls.images = {}, {}
        for ns in ('node', 'nodelet', 'failing'):
            for name, kind in (('mask', Image), ('detections', DetectedObjects),
                               ('detector/overlay', Image)):
                cls.got[ns, name] = {}
                cls.keep_alive.append(rospy.Subscriber('/%s/%s' % (ns, name), kind,
                                                       cls.store(cls.got[ns, name])))
            cls.images[ns] = rospy.Publisher('/%s/image' % ns, Image, queue_size=5)
            cls.wait(lambda p=cls.images[ns]: p.get_num_connections() > 0, 30)
        time.sleep(0.5)  # the detectors need time to connect to the subscribers above

    def detect(self, ns, image, stamp, seconds=10):
        """Sends an image and waits for its mask and its list."""
        self.images[ns].publish(at(image, stamp))
        key = stamp.to_nsec()
        with self.changed:
            self.changed.wait_for(
                lambda: key in self.got[ns, 'mask'] and key in self.got[ns, 'detections'], seconds)
            self.assertIn(key, self.got[ns, 'mask'])
            return self.got[ns, 'mask'][key], self.got[ns, 'detections'][key]

    def test_every_image_is_answered(self):
        for ns, first in (('node', 1000), ('nodelet', 2000)):
            seen = 0
            for i, frame in enumerate(self.recording.frames[:30]):
                stamp = rospy.Time.from_sec(first + i / 15)
                mask, objects = self.detect(ns, frame['image'], stamp)
                self.assertEqual((mask.width, mask.height, mask.encoding),
                                 (frame['image'].width, frame['image'].height, 'mono8'))
                self.assertEqual(mask.header.frame_id, frame['image'].header.frame_id)
                self.assertEqual(objects.header.frame_id, frame['image'].header.frame_id)
                self.assertEqual(any(mask.data), len(objects.objects) > 0)
                for thing in objects.objects:
                    self.assertIn(thing.class_name, ('person', 'sofa', 'chair', 'computer', 'screen'))
                    self.assertGreater(thing.track_id, 0)
                    self.assertTrue(0 < thing.score <= 1)
                    self.assertTrue(thing.width > 0 and thing.height > 0)
                    if ns == 'node':
                        # The network runs on every image. An object that it misses once is kept
                        # for one more image.
                        self.assertLess(thing.age, 1.5 / 15)
                seen += len(objects.objects) > 0
            # Masks do not wait for the network. On a busy machine the flight may be over before its
            # first result. So the last image is sent until there is one.
            until = time.time() + 20
            while seen <= 5 and time.time() < until:
                i += 1
                time.sleep(0.05)
                _, objects = self.detect(ns, frame['image'], rospy.Time.from_sec(first + i / 15))
                seen += len(objects.objects) > 0
            self.assertGreater(seen, 5, 'the flight shows a person and furniture')
            self.assertTrue(self.wait(lambda: len(self.got[ns, 'detector/overlay']) > 0))

    def test_bad_images_and_time_that_goes_back(self):
        image = self.recording.frames[0]['image']
        broken = copy.deepcopy(image)
        broken.data = broken.data[:1000]
        for ns in ('node', 'nodelet'):
            self.images[ns].publish(at(broken, rospy.Time(3000)))
            time.sleep(0.3)
            self.assertNotIn(rospy.Time(3000).to_nsec(), self.got[ns, 'mask'])
            self.detect(ns, image, rospy.Time(3001))
            self.detect(ns, image, rospy.Time(500))  # as in a bag that is played in a loop
            small = copy.deepcopy(image)
            small.width, small.height = 40, 30
            small.step = 120
            small.data = small.data[:3600]
            mask, _ = self.detect(ns, small, rospy.Time(501))
            self.assertEqual(mask.width, 40)

    def shown(self):
        """Searches an image in which the network finds an object without earlier images."""
        for i, frame in enumerate(self.recording.frames[::5]):
            # The clock jumps back every time, so the tracker knows no object.
            mask, _ = self.detect('node', frame['image'], rospy.Time(9000 - 10 * i))
            if any(mask.data):
                return frame['image']
        self.fail('the network sees nothing')

    def test_late_images_and_jumps(self):
        image = self.shown()
        self.detect('nodelet', image, rospy.Time(8100))
        mask, _ = self.detect('nodelet', image, rospy.Time(8000))
        self.assertTrue(any(mask.data), 'the first mask after a jump back waits')
        mask, objects = self.detect('nodelet', image, rospy.Time.from_sec(8000.1))
        before = sorted(thing.track_id for thing in objects.objects)
        late = rospy.Time.from_sec(8000.05)
        self.images['nodelet'].publish(at(image, late))
        time.sleep(0.5)
        self.assertNotIn(late.to_nsec(), self.got['nodelet', 'mask'])
        mask, objects = self.detect('nodelet', image, rospy.Time.from_sec(8000.2))
        self.assertTrue(any(mask.data), 'a late image changes nothing')
        self.assertEqual(sorted(thing.track_id for thing in objects.objects), before)

    def test_images_of_16_bits(self):
        image = copy.deepcopy(self.recording.frames[0]['image'])
        image.encoding, image.step, image.is_bigendian = 'mono16', 2 * image.width, 0
        # The low byte comes first. It is always zero here.
        image.data = b''.join(bytes((0, green)) for green in image.data[1::3])
        mask, _ = self.detect('node', image, rospy.Time(10000))
        self.assertEqual((mask.width, mask.encoding), (image.width, 'mono8'))

    def diagnoses(self, ns, image, stamps, text):
        """Sends images until diagnostics show the text. Returns all messages up to then."""
        messages = []

        def look(message):
            with self.changed:
                messages.extend(status.message for status in message.status
                                if 'detection' in status.name and ns + '/detector' in status.name)
        subscriber = rospy.Subscriber('/diagnostics', DiagnosticArray, look)
        for stamp in stamps:
            self.images[ns].publish(at(image, stamp))
            time.sleep(0.1)
            if any(text in message for message in messages):
                break
        subscriber.unregister()
        self.assertTrue(any(text in message for message in messages), messages)
        return messages

    def test_images_without_stamps(self):
        image = self.recording.frames[0]['image']
        self.diagnoses('node', image, [rospy.Time(0)] * 100, 'no stamp')
        self.assertNotIn(0, self.got['node', 'mask'])

    def test_a_network_that_fails_is_told(self):
        white = filled(self.recording.frames[0]['image'], 255)
        black = filled(self.recording.frames[0]['image'], 0)

        def stamps(first):
            return [rospy.Time.from_sec(first + 0.1 * i) for i in range(100)]
        self.diagnoses('failing', black, stamps(1000), 'masks go out')
        self.diagnoses('failing', white, stamps(1020), 'not finite')
        # The fault is reported as long as it lasts, although the images themselves are good.
        self.assertNotIn('masks go out', self.diagnoses('failing', white, stamps(1040), 'not finite'))
        self.diagnoses('failing', black, stamps(1060), 'masks go out')

    def test_diagnostics(self):
        found = threading.Event()

        def look(message):
            for status in message.status:
                keys = {v.key for v in status.values}
                if 'detection' in status.name and {'network ms', 'tracking ms'} <= keys:
                    found.set()
        subscriber = rospy.Subscriber('/diagnostics', DiagnosticArray, look)
        for i in range(20):
            self.detect('node', self.recording.frames[0]['image'], rospy.Time.from_sec(4000 + 0.2 * i))
            if found.wait(0.2):
                break
        subscriber.unregister()
        self.assertTrue(found.is_set())

    def test_wrong_parameters_are_one_line(self):
        check_ends_with_one_line(self, 'edge_mcl_detector', ['_dilatoin:=3'], 2, 'dilation')
        check_ends_with_one_line(self, 'edge_mcl_detector', ['_ignore_classes:=persons'], 2, 'person')
        check_ends_with_one_line(self, 'edge_mcl_detector', ['_model:=/nowhere.yaml'], 3, 'nowhere')

    def never_wrong(self, first, last, **more):
        """Sends images. Every pose in the state tracking must be right, within 0.25 m and 5 degrees."""
        states = []
        for i in range(first, last):
            status = self.send(i, **more)
            states.append(status)
            if status.state_name == 'tracking':
                metres, degrees = self.error(i)
                self.assertLess(metres, 0.25, 'image %d' % i)
                self.assertLess(degrees, 5, 'image %d' % i)
        return states

    def test_a_detector_that_marks_everything(self):
        self.begin()
        frames = self.recording.frames
        self.track(0, 10, mask=frames[0]['mask'])
        states = self.never_wrong(10, 25, mask=filled(frames[0]['image'], 255))
        self.assertIn(states[-1].state_name, ('degraded', 'lost'))
        self.assertIn('mask', states[-1].problem)
        self.assertAlmostEqual(states[-1].masked_share, 1)
        self.track(25, 40, mask=frames[25]['mask'])

    def test_a_detector_that_marks_nothing(self):
        self.begin()
        frames = self.recording.frames
        states = self.never_wrong(0, 40, mask=filled(frames[0]['image'], 0))
        self.assertEqual(states[-1].masked_share, 0)
        self.assertEqual(states[-1].state_name, 'tracking')

    def test_a_detector_that_hangs_for_five_seconds(self):
        self.rate = 7.5  # half of the rate, because the recording is short
        self.begin()
        frames = self.recording.frames
        self.track(0, 8, mask=frames[0]['mask'])
        states = self.never_wrong(8, 47)
        for status in states:
            self.assertGreater(status.mask_age, 0, 'the last mask, moved')
        self.assertGreater(states[-1].mask_age, 5)
        self.track(47, 57, mask=frames[47]['mask'])


if __name__ == '__main__':
    rospy.init_node('detector_test')
    rostest.rosrun('edge_mcl', 'detector', Detector, sys.argv)
