#!/usr/bin/python3
"""When a simulated clock begins anew, diagnostics must go on."""
import collections
import sys
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Clock


class ClockThatJumps(unittest.TestCase):
    def test_diagnostics_go_on(self):
        received = collections.Counter()

        def keep(message):
            for status in message.status:
                received[status.name.split(':')[0]] += 1
        subscriber = rospy.Subscriber('/diagnostics', DiagnosticArray, keep)
        clock = rospy.Publisher('/clock', Clock, queue_size=10)

        def run(begin, seconds):
            until = time.time() + seconds
            while time.time() < until:
                clock.publish(Clock(rospy.Time.from_sec(begin + seconds - (until - time.time()))))
                time.sleep(0.05)
        until = time.time() + 20  # nodes begin when the clock has a time
        while len(received) < 2 and time.time() < until:
            run(100 + 20 - (until - time.time()), 0.5)
        for name in ('detector', 'localizer'):
            self.assertIn(name, received)
        received.clear()
        run(1, 5)  # one message may come before the nodes notice the jump
        for name in ('detector', 'localizer'):
            self.assertGreaterEqual(received[name], 3, name)
        subscriber.unregister()


if __name__ == '__main__':
    rospy.init_node('clock_test')
    rostest.rosrun('edge_mcl', 'clock', ClockThatJumps, sys.argv)
