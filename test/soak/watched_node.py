"""A ROS node as a process: starts, kills and pauses it, and measures its memory."""
import os
import signal
import subprocess
import time

import roslib.packages


class WatchedNode:
    """`name`: type in the package edge_mcl and name in ROS. The output goes to LOGS/NAME.log."""

    def __init__(self, name, arguments, logs):
        found = roslib.packages.find_node('edge_mcl', name)
        if not found:
            raise SystemExit('%s is not built' % name)
        self.name, self.command = name, [found[0]] + arguments + ['__name:=' + name]
        self.log_file = os.path.join(logs, name + '.log')
        self.process, self.began, self.wanted = None, 0.0, False
        self.crashes = []  # texts, one per unwanted end
        self.lives = []    # per life: [(s since its begin, resident kB, open files, threads)]

    def start(self):
        with open(self.log_file, 'ab') as log:
            self.process = subprocess.Popen(self.command, stdout=log, stderr=subprocess.STDOUT)
        self.began, self.wanted = time.time(), True
        self.lives.append([])

    def end(self, kill=False):
        """Asks the node to end, or kills it. A node that does not end within 15 s counts as a crash."""
        self.wanted = False
        self.process.send_signal(signal.SIGKILL if kill else signal.SIGINT)
        try:
            code = self.process.wait(15)
            if not kill and code not in (0, -signal.SIGINT):
                self.crashes.append('ended with %d when asked to end' % code)
        except subprocess.TimeoutExpired:
            self.crashes.append('did not end within 15 s')
            self.process.kill()
            self.process.wait()

    def pause(self):
        self.process.send_signal(signal.SIGSTOP)

    def resume(self):
        self.process.send_signal(signal.SIGCONT)

    def revive(self):
        """If the node ended by itself, notes a crash and starts it anew. @return whether it had ended"""
        code = self.process.poll()
        if code is None or not self.wanted:
            return False
        self.crashes.append('ended with %d after %.0f s' % (code, time.time() - self.began))
        self.start()
        return True

    def measure(self):
        try:
            with open('/proc/%d/status' % self.process.pid) as status:
                fields = dict(line.split(':', 1) for line in status)
            files = len(os.listdir('/proc/%d/fd' % self.process.pid))
            self.lives[-1].append((time.time() - self.began, int(fields['VmRSS'].split()[0]), files,
                                   int(fields['Threads'])))
        except (OSError, KeyError):
            pass  # the node has just ended; revive() notes it

    def figures(self):
        """Lines of a table: name, life, s since its begin, resident kB, open files, threads."""
        for number, life in enumerate(self.lives, 1):
            for measured in life:
                yield '%s,%d,%.0f,%d,%d,%d' % ((self.name, number) + measured)

    def longestLife(self):
        return max(self.lives, key=lambda life: life[-1][0] if life else 0, default=[])
