#!/usr/bin/python3
"""Runs the whole ROS system for an hour with random faults. Does it crash, grow, or stay lost?"""
import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time

import rospy
import yaml
from edge_mcl.msg import Status
from geometry_msgs.msg import PoseWithCovarianceStamped

from faults import everyFault
from flight_feeder import FlightFeeder, difference, matrix
from soak_report import writeReport
from watched_node import WatchedNode

RIGHT = (0.25, 5.0)   # m, degrees: a tracked pose with smaller errors is right
ANNOUNCED_WITHIN = 2  # s of flight in which the localizer must notice that it was carried away


class Recovery:
    """How a fault ended. `flight` and `wall`: seconds until the state was tracking again; None: never."""

    def __init__(self, at, fault, images, flight, wall):
        self.at, self.fault, self.images, self.flight, self.wall = at, fault, images, flight, wall


class Silent:
    """A wrong pose in the state tracking. `fault`: the last fault before it."""

    def __init__(self, stamp, metres, degrees, fault):
        self.stamp, self.metres, self.degrees, self.fault = stamp, metres, degrees, fault


class Judge:
    """Compares the state and pose of every image with the ground truth."""

    def __init__(self, feeder, log_file):
        self.feeder, self.lock, self.log_file = feeder, threading.Lock(), log_file
        self.statuses, self.poses = {}, {}
        self.tracking, self.silent, self.right_in_a_row = 0, [], 0
        self.carried_at = None  # stamp, s
        self.fault = 'the begin'
        self.state, self.problem = 'nothing yet', ''
        self.subscribers = [
            rospy.Subscriber('/edge_mcl_localizer/status', Status, self.receive, self.statuses),
            rospy.Subscriber('/pose', PoseWithCovarianceStamped, self.receive, self.poses)]

    def receive(self, message, where):
        stamp = message.header.stamp.to_nsec()
        with self.lock:
            where[stamp] = message
            self.judge(stamp)
            while len(where) > 200:
                del where[next(iter(where))]

    def judge(self, stamp):
        status = self.statuses.get(stamp)
        if not status:
            return
        self.state, self.problem = status.state_name, status.problem
        if status.state != Status.TRACKING:
            self.right_in_a_row = 0
            return
        with self.feeder.lock:
            truth = self.feeder.truth_at.get(stamp)
        if stamp not in self.poses or truth is None:
            return
        pose = self.poses[stamp].pose.pose
        metres, degrees = difference(truth, matrix(pose.position, pose.orientation))
        self.tracking += 1
        if metres <= RIGHT[0] and degrees <= RIGHT[1]:
            self.right_in_a_row += 1
            return
        self.right_in_a_row = 0
        since = None if self.carried_at is None else stamp * 1e-9 - self.carried_at
        if since is None or not 0 <= since <= ANNOUNCED_WITHIN:
            self.silent.append(Silent(stamp * 1e-9, metres, degrees, self.fault))
            with open(self.log_file, 'a') as log:
                print('%.1f s: tracking with an error of %.2f m and %.1f degrees, after: %s' % (
                    stamp * 1e-9, metres, degrees, self.fault), file=log)

    def forget(self, fault, carried_at):
        with self.lock:
            self.right_in_a_row, self.carried_at, self.fault = 0, carried_at, fault


class Soak:
    def __init__(self, arguments):
        self.arguments = arguments
        self.random = random.Random(arguments.seed)
        self.gentle, self.restarts = self.chosenFaults()
        self.recoveries, self.nodes = [], {}
        self.began = self.measured = self.restarted = time.time()

    def start(self):
        a = self.arguments
        rospy.set_param('/use_sim_time', True)
        config = os.path.join(os.path.dirname(__file__), '..', '..', 'config', 'localizer.yaml')
        subprocess.run(['rosparam', 'load', config, '/edge_mcl_localizer'], check=True)
        for name, value in (('model_file', os.path.abspath(a.model)), ('use_masks', True),
                            ('global_start', True), ('likelihood/cues', a.cues),
                            ('filter/particles', a.particles)):
            rospy.set_param('/edge_mcl_localizer/' + name, value)
        for setting in a.set:
            name, value = setting.split('=', 1)
            rospy.set_param('/edge_mcl_localizer/' + name, yaml.safe_load(value))
        rospy.set_param('/edge_mcl_viewer/headless', True)
        rospy.set_param('/edge_mcl_viewer/pictures', os.path.join(a.out, 'viewer'))
        rospy.set_param('/edge_mcl_viewer/pictures_at', '5')
        camera = ['image:=camera/image_raw', 'mask:=detected/mask',
                  'detections:=detected/detections']
        more = ['camera_info:=camera/camera_info', 'depth:=camera/depth/image_raw',
                'depth/camera_info:=camera/camera_info']
        rospy.init_node('soak', disable_signals=True)
        self.feeder = FlightFeeder(a.bag, a.rate, a.every)
        self.judge = Judge(self.feeder, os.path.join(a.out, 'faults.log'))
        for name, remaps in (('edge_mcl_localizer', camera + more), ('edge_mcl_detector', camera),
                             ('edge_mcl_viewer',
                              camera + more + ['status:=edge_mcl_localizer/status'])):
            self.nodes[name] = WatchedNode(name, remaps, a.out)
            self.nodes[name].start()
        until = time.time() + 30
        while self.feeder.image.get_num_connections() < len(self.nodes) and time.time() < until:
            time.sleep(0.1)
        self.began = self.measured = self.restarted = time.time()
        self.feeder.begin()

    def fly(self, images):
        for _ in range(images):
            self.feeder.fly()
            self.look()

    def look(self):
        """Every five seconds: measures the nodes and starts crashed ones again."""
        if time.time() - self.measured < 5:
            return
        self.measured = time.time()
        for node in self.nodes.values():
            if node.wanted and not node.revive():
                node.measure()
        if sys.stdout.isatty():
            minutes = (time.time() - self.began) / 60
            print('\r%5.1f of %g min, %d faults, %s        ' % (
                minutes, self.arguments.minutes, len(self.recoveries), self.judge.state), end='')
            sys.stdout.flush()

    def awaitTracking(self):
        """Flies on until ten images in a row are tracked at right poses.

        @return seconds of flight, seconds of the wall clock; None, None after `patience` seconds
        """
        begin, flown = time.time(), 0
        while self.judge.right_in_a_row < 10:
            if time.time() - begin > self.arguments.patience:
                return None, None
            self.fly(1)
            flown += 1
        return flown * self.feeder.step, time.time() - begin

    def suffer(self, fault):
        images = self.random.randint(*fault.images)
        before = self.feeder.now, self.feeder.at
        fault.begin(self)
        carried = before != (self.feeder.now, self.feeder.at)
        self.judge.forget(fault.name, self.feeder.now if carried else None)
        self.fly(images)
        fault.end(self)
        flight, wall = self.awaitTracking()
        minutes = (time.time() - self.began) / 60
        self.note(Recovery(minutes, fault.name, images, flight, wall))

    def note(self, recovery):
        self.recoveries.append(recovery)
        line = '%.1f min: %s for %d images: ' % (recovery.at, recovery.fault, recovery.images)
        line += 'tracking after %.1f s of flight' % recovery.flight if recovery.flight is not None else (
            'NOT BACK: %s (%s)' % (self.judge.state, self.judge.problem))
        with open(os.path.join(self.arguments.out, 'faults.log'), 'a') as log:
            print(line, file=log)

    def chosenFaults(self):
        gentle, restarts = everyFault()
        if not self.arguments.faults:
            return gentle, restarts
        chosen = set(self.arguments.faults.split(','))
        unknown = chosen - {f.name for f in gentle + restarts}
        if unknown:
            raise SystemExit('no such fault: %s; there are: %s' % (
                ', '.join(sorted(unknown)), ', '.join(f.name for f in gentle + restarts)))
        return [f for f in gentle if f.name in chosen], [f for f in restarts if f.name in chosen]

    def run(self):
        flight, wall = self.awaitTracking()
        self.note(Recovery(0.0, 'the begin', 0, flight, wall))
        while time.time() < self.began + 60 * self.arguments.minutes:
            self.fly(self.random.randint(20, 60))
            due = time.time() - self.restarted > 60 * self.arguments.restart_every
            if self.restarts and (due or not self.gentle):
                self.restarted = time.time()
                self.suffer(self.random.choice(self.restarts))
            else:
                self.suffer(self.random.choice(self.gentle))

    def end(self):
        for node in self.nodes.values():
            if node.wanted and node.process.poll() is None:
                node.resume()
                node.end()


def parse():
    parser = argparse.ArgumentParser(prog='scripts/soak', description=__doc__)
    parser.add_argument('--bag', required=True, help='of edge-mcl simulate')
    parser.add_argument('--model', required=True)
    parser.add_argument('--out', default='soak_output')
    parser.add_argument('--minutes', type=float, default=60)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--rate', type=float, default=10, help='images per second of the wall clock')
    parser.add_argument('--every', type=int, default=2, help='of the bag, each so many-th image')
    parser.add_argument('--cues', default='edges', choices=('edges', 'depth', 'both'))
    parser.add_argument('--particles', type=int, default=500)
    parser.add_argument('--patience', type=float, default=120,
                        help='s within which it must track again')
    parser.add_argument('--restart-every', type=float, default=12,
                        help='min between ends of a process; rare, so that a leak can be seen')
    parser.add_argument('--set', action='append', default=[], metavar='GROUP/NAME=VALUE',
                        help='a parameter of the localizer')
    parser.add_argument('--faults', default='', help='only these, with commas')
    return parser.parse_args()


def main():
    arguments = parse()
    for setting in arguments.set:
        if '=' not in setting:
            raise SystemExit('--set %s: GROUP/NAME=VALUE expected' % setting)
    for file in (arguments.bag, arguments.model):
        if not os.path.isfile(file):
            raise SystemExit('%s: no such file' % file)
    arguments.out = os.path.abspath(arguments.out)
    shutil.rmtree(arguments.out, ignore_errors=True)
    os.makedirs(arguments.out)
    soak = Soak(arguments)
    # This soak has its own master, so that other ROS systems are not disturbed.
    port = random.randint(20000, 40000)
    os.environ['ROS_MASTER_URI'] = 'http://localhost:%d' % port
    with open(os.path.join(arguments.out, 'roscore.log'), 'w') as log:
        master = subprocess.Popen(['roscore', '-p', str(port)], stdout=log, stderr=log)
    try:
        time.sleep(4)
        soak.start()
        soak.run()
    except KeyboardInterrupt:
        print('\nstopped')
    finally:
        soak.end()
        master.send_signal(signal.SIGINT)
        master.wait()
    return writeReport(soak, os.path.join(arguments.out, 'report.md'))


if __name__ == '__main__':
    sys.exit(main())
