"""Checks that a node that cannot begin ends with one clear line."""
import os
import subprocess
import sys


def check_ends_with_one_line(test, node, parameters, status, text):
    """Runs a node. It must end by itself with this status and one line that holds the text."""
    file = os.path.join(os.path.dirname(sys.argv[0]), node)
    run = subprocess.run([file, '__name:=ends_%d' % abs(hash(tuple(parameters)))] + parameters,
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                         universal_newlines=True, timeout=30)
    test.assertEqual(run.returncode, status, run.stdout)
    test.assertIn(text, run.stdout)
    test.assertEqual(len([line for line in run.stdout.splitlines() if 'FATAL' in line]), 1)
