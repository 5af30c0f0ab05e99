#!/usr/bin/python3
"""Faults of a robot's sensors: the localizer must report them, give no wrong pose, and recover."""
import copy
import os
import sys
import threading
import time

import dynamic_reconfigure.client
import rospy
import rostest
from edge_mcl.srv import SetPose, UseFile
from std_srvs.srv import Empty

from fed_localizer import FedLocalizer


class Faults(FedLocalizer):
    namespaces = ['plain', 'skip_update', 'use_last', 'unmasked']

    def test_black_images_then_recovery(self):
        self.begin()
        self.track(0, 20)  # until the particles no longer come closer together
        black = copy.deepcopy(self.recording.frames[0]['image'])
        black.data = bytes(len(black.data))
        states = []
        for i in range(20, 50):  # two seconds
            status = self.send(i, image=black)
            states.append(status.state_name)
            self.assertIn('hardly any edges', status.problem)
        self.assertEqual(states[0], 'degraded')
        self.assertEqual(states[-1], 'lost')
        widened = self.statuses['plain'][self.stamp(49).to_nsec()]
        before = self.statuses['plain'][self.stamp(19).to_nsec()]
        self.assertGreater(widened.position_std, 1.5 * before.position_std)
        self.track(50, 60)

    def test_clock_jumps_back(self):
        self.begin()
        self.track(0, 20)
        # The recording begins again at its own times, without a new initial pose.
        Faults.now += 10
        for ns in self.namespaces:
            self.statuses[ns].clear()
        self.start += 0.0
        time.sleep(0.1)
        for i in range(0, 30):
            status = self.send(i, tf=False)
            if i == 0:
                self.assertIn('jumped back', status.problem)
            if i < 10:  # the robot may be elsewhere, so the pose must be proven
                self.assertEqual(status.state_name, 'converging', status.problem)
        self.assertEqual(status.state_name, 'tracking', status.problem)
        metres, degrees = self.error(29)
        self.assertLess(metres, 0.05)
        self.assertLess(degrees, 1.5)

    def test_image_out_of_order(self):
        self.begin()
        self.track(0, 10)
        with self.changed:
            self.statuses['plain'].pop(self.stamp(5).to_nsec())
        status = self.send(5, tf=False)
        self.assertIn('older', status.problem)
        self.track(10, 15)

    def test_late_transform(self):
        self.begin()
        self.track(0, 8)
        status = self.send(8, tf=False)  # the image waits for tf and is then used without it
        self.assertIn('no odometry', status.problem)
        # The transform comes while the image waits for it.
        timer = threading.Timer(0.05, lambda: self.send_tf(9))
        timer.start()
        status = self.send(9, tf=False)
        timer.join()
        self.assertNotIn('no odometry', status.problem)
        self.track(10, 20)

    def test_nan_in_odometry(self):
        self.begin()
        self.track(0, 8)

        def spoil(transform):
            transform.translation.x = float('nan')
        self.send_tf(8, spoil)
        status = self.send(8, tf=False)
        self.assertIn('no odometry', status.problem)
        self.track(9, 20)

    def test_nan_and_broken_initial_pose(self):
        self.begin()
        self.track(0, 8)
        for field in ('position', 'covariance', 'orientation'):
            pose = copy.deepcopy(self.recording.initial_pose)
            if field == 'position':
                pose.pose.pose.position.x = float('nan')
            elif field == 'covariance':
                pose.pose.covariance = [float('nan')] * 36
            else:
                pose.pose.pose.orientation.w = 5
            self.publishers['plain', 'initialpose'].publish(pose)
            answer = rospy.ServiceProxy('/plain/localizer/set_pose', SetPose)(pose)
            self.assertFalse(answer.success)
            self.assertIn('initial pose', answer.message)
        self.track(8, 12)

    def test_initial_pose_in_another_frame(self):
        self.begin()
        self.track(0, 8)
        unknown = copy.deepcopy(self.recording.initial_pose)
        unknown.header.frame_id = 'nowhere'
        answer = rospy.ServiceProxy('/plain/localizer/set_pose', SetPose)(unknown)
        self.assertFalse(answer.success)
        self.assertIn('nowhere', answer.message)
        # The frame `beside` has its origin 5 m beside the origin of the map. So the same place has another x.
        message = copy.deepcopy(self.recording.mounting)
        transform = message.transforms[0]
        transform.header.frame_id, transform.child_frame_id = 'map', 'beside'
        transform.transform.translation.x, transform.transform.translation.y = 5.0, 0.0
        transform.transform.translation.z = 0.0
        r = transform.transform.rotation
        r.x, r.y, r.z, r.w = 0.0, 0.0, 0.0, 1.0
        self.tf_static.publish(message)
        pose = copy.deepcopy(self.recording.initial_pose)
        pose.header.frame_id = 'beside'
        pose.pose.pose.position.x -= 5.0
        self.begin()
        service = rospy.ServiceProxy('/plain/localizer/set_pose', SetPose)
        self.assertTrue(self.wait(lambda: service(pose).success))
        self.track(0, 8)

    def test_no_camera_info(self):
        # Tests run in the order of their names. So this localizer has not had any message yet.
        self.begin('unmasked')
        status = self.send(0, 'unmasked', info=False)
        if 'no camera_info' not in status.problem:
            self.skipTest('another test came first')
        self.assertIn(status.state_name, ('converging', 'degraded'))
        self.track(1, 10, 'unmasked', mask=self.recording.frames[0]['mask'])

    def test_camera_info_of_another_size(self):
        self.begin()
        self.track(0, 8)
        info = copy.deepcopy(self.recording.frames[0]['info'])
        info.width, info.height = 640, 480
        status = self.send(8, info=info)
        self.assertIn('640x480', status.problem)
        self.assertEqual(status.state_name, 'degraded')
        self.track(9, 14)

    def test_truncated_image_and_odd_encoding(self):
        self.begin()
        self.track(0, 8)
        short = copy.deepcopy(self.recording.frames[8]['image'])
        short.data = short.data[:1000]
        self.assertIn('truncated', self.send(8, image=short).problem)
        odd = copy.deepcopy(self.recording.frames[9]['image'])
        odd.encoding = 'smell'
        self.assertIn('smell', self.send(9, image=odd).problem)
        self.track(10, 15)

    def test_mask_of_wrong_size_or_kind(self):
        frames = self.recording.frames
        self.begin('skip_update')
        self.track(0, 8, 'skip_update', mask=frames[0]['mask'])
        small = copy.deepcopy(frames[8]['mask'])
        small.width, small.step = 160, 160
        small.data = small.data[:160 * small.height]
        status = self.send(8, 'skip_update', mask=small)
        self.assertIn('mask', status.problem)
        self.assertEqual(status.state_name, 'degraded')
        status = self.send(9, 'skip_update', mask=frames[9]['image'])
        self.assertIn('mono8', status.problem)
        self.track(10, 15, 'skip_update', mask=frames[10]['mask'])

    def test_mask_over_everything(self):
        frames = self.recording.frames
        self.begin('skip_update')
        self.track(0, 8, 'skip_update', mask=frames[0]['mask'])
        full = copy.deepcopy(frames[8]['mask'])
        full.data = b'\xff' * len(full.data)
        status = self.send(8, 'skip_update', mask=full)
        self.assertEqual(status.state_name, 'degraded')
        self.assertAlmostEqual(status.masked_share, 1)
        self.assertIn('too little', status.problem)
        self.track(9, 15, 'skip_update', mask=frames[9]['mask'])

    def test_masks_never_come_skip_update(self):
        self.begin('skip_update')
        for i in range(3):
            status = self.send(i, 'skip_update')
            self.assertIn('no mask in time', status.problem)
            self.assertEqual(status.update_ms < 1e4, True)
        self.assertNotEqual(status.state_name, 'tracking')

    def test_masks_never_come_use_last(self):
        frames = self.recording.frames
        self.begin('use_last')
        self.track(0, 8, 'use_last', mask=frames[0]['mask'])
        status = self.send(8, 'use_last')
        self.assertAlmostEqual(status.mask_age, 1 / 15, places=3)
        self.assertGreater(status.masked_share, 0)
        self.track(9, 12, 'use_last')

    def test_masks_never_come_unmasked(self):
        self.begin('unmasked')
        status = self.track(0, 10, 'unmasked')
        self.assertEqual(status.mask_age, -1)
        self.assertEqual(status.masked_share, 0)

    def test_reload_model(self):
        self.begin()
        self.track(0, 8)
        reload_model = rospy.ServiceProxy('/plain/localizer/reload_model', UseFile)
        broken = os.path.join(self.folder.name, 'broken.obj')
        with open(broken, 'w') as f:
            f.write('v 0 0 zero\nf 1 2 3\n')
        empty = os.path.join(self.folder.name, 'empty.obj')
        open(empty, 'w').close()
        for file in (broken, empty, '/nowhere/model.obj'):
            answer = reload_model(file)
            self.assertFalse(answer.success)
            self.assertIn('is kept', answer.message)
        self.track(8, 12)
        answer = reload_model('')
        self.assertTrue(answer.success, answer.message)
        self.track(12, 18)

    def test_particles_are_saved_and_loaded(self):
        self.begin()
        self.track(0, 10)
        file = os.path.join(self.folder.name, 'particles.txt')
        save = rospy.ServiceProxy('/plain/localizer/save_particles', UseFile)
        load = rospy.ServiceProxy('/plain/localizer/load_particles', UseFile)
        answer = save(file)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.message, '300 particles')
        self.assertFalse(save('/nowhere/particles.txt').success)
        answer = load('/nowhere/particles.txt')
        self.assertFalse(answer.success)
        with open(file) as f:
            lines = f.readlines()
        with open(file + '.broken', 'w') as f:
            f.writelines(lines[:5] + ['1 2 nonsense\n'])
        answer = load(file + '.broken')
        self.assertFalse(answer.success)
        self.assertIn('line 6', answer.message)
        self.assertTrue(load(file).success)
        self.track(10, 15)

    def test_adjusted_while_it_runs(self):
        client = dynamic_reconfigure.client.Client('/plain/localizer/adjust', timeout=10)
        self.begin()
        self.track(0, 8)
        before = client.get_configuration()
        self.assertAlmostEqual(before['min_match_ratio'], 0.1)
        client.update_configuration({'min_edge_pixels': 900000})
        status = self.send(8)
        self.assertIn('hardly any edges', status.problem)
        client.update_configuration({'min_edge_pixels': before['min_edge_pixels']})
        self.track(9, 12)

    def test_request_nomotion_update(self):
        rospy.ServiceProxy('/plain/request_nomotion_update', Empty)()

    def test_the_pose_is_stored(self):
        self.begin()
        self.track(0, 10)
        x = self.recording.frames[9]['truth'].pose.position.x
        self.assertTrue(self.wait(
            lambda: abs(rospy.get_param('/plain/localizer/initial_pose_x', 99) - x) < 0.05))


if __name__ == '__main__':
    rospy.init_node('faults_test')
    rostest.rosrun('edge_mcl', 'faults', Faults, sys.argv)
