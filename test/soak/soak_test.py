#!/usr/bin/python3
"""A soak of half a minute makes faults. The system must recover, and the report must be written."""
import os
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.realpath(__file__))
TOOL = sys.argv.pop(1)
MODEL = os.path.join(HERE, '..', '..', 'maps', 'office.obj')


class Soak(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.bag = os.path.join(cls.folder.name, 'flight.bag')
        subprocess.run([TOOL, 'simulate', os.path.join(HERE, '..', 'data', 'small_flight.yaml'), cls.bag],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def soak(self, *options):
        out = os.path.join(self.folder.name, 'out')
        run = subprocess.run(
            ['/usr/bin/python3', os.path.join(HERE, 'soak.py'), '--bag', self.bag, '--model', MODEL,
             '--out', out, '--every', '1', '--particles', '200', *options],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
        return run.returncode, run.stdout

    def test_comes_back(self):
        code, said = self.soak('--minutes', '0.5', '--restart-every', '0.1', '--faults',
                               'dark,no odometry,edge_mcl_detector killed,edge_mcl_viewer restarted')
        self.assertEqual(code, 0, said)
        self.assertIn('* crashes: 0', said)
        self.assertRegex(said, r'\* faults: [1-9]\d*, after 0 of them')
        self.assertRegex(said, r'\| edge_mcl_localizer \| 1 \|')
        self.assertRegex(said, r'\| edge_mcl_\w+ (restarted|killed) \|')

    def test_what_does_not_come_back_is_told(self):
        # With a patience of zero the localizer has no time to track again.
        code, said = self.soak('--minutes', '0.1', '--patience', '0', '--faults', 'dark')
        self.assertEqual(code, 1, said)
        self.assertRegex(said, r'after [1-9]\d* of them it did not track again')

    def test_wrong_options(self):
        code, said = self.soak('--minutes', '0.05', '--faults', 'earthquake')
        self.assertNotEqual(code, 0)
        self.assertIn('no such fault: earthquake; there are: no image', said)


if __name__ == '__main__':
    unittest.main()
