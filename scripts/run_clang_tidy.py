#!/usr/bin/env python3
"""Runs clang-tidy on sources, two at a time.

usage: run_clang_tidy.py BUILD_DIR FILE ...

Files that the build directory does not compile are left out. clang-tidy spends most of its time in
headers of other libraries. So the sources of one folder are checked as one file that includes them
all. When two of them define the same name, which is legal in separate files, each is checked alone.

The build compiles with headers that GCC has precompiled. Clang cannot read them, so they are taken
out of the commands.
"""
import collections
import concurrent.futures
import json
import os
import re
import subprocess
import sys
import tempfile
import time

MOST_TOGETHER = 12  # sources; more would leave a core idle at the end


def command_of(entry):
    command = re.sub(r'-include \S*cmake_pch\.hxx', '', entry['command'])
    for option in ('-Winvalid-pch', '-fpch-preprocess', '-fno-semantic-interposition'):
        command = command.replace(option, '')  # clang does not know them, and a warning is an error
    return command


def includes_itself(file):
    """Highway compiles such a file several times, so it cannot be included by another."""
    with open(file, encoding='utf-8') as f:
        return 'HWY_TARGET_INCLUDE' in f.read()


def groups_of(files):
    """Files of one folder together, at most MOST_TOGETHER."""
    folders = collections.defaultdict(list)
    for file in files:
        if includes_itself(file):
            folders[file].append(file)
        else:
            folders[os.path.dirname(file)].append(file)
    groups = []
    for members in folders.values():
        parts = -(-len(members) // MOST_TOGETHER)
        groups += [members[k::parts] for k in range(parts)]
    return sorted(groups, key=len, reverse=True)  # long ones first


class Tidy:
    def __init__(self, entries, folder, root):
        self.entries, self.folder, self.root = entries, folder, root

    def run(self, name, members):
        """Checks the members as one source. Returns the exit status and the text."""
        folder = os.path.join(self.folder, name)
        os.mkdir(folder)
        source = members[0]
        command = command_of(self.entries[source])
        if len(members) > 1:
            source = os.path.join(folder, 'together.cpp')
            with open(source, 'w', encoding='utf-8') as f:
                f.writelines('#include "%s"  // NOLINT(bugprone-suspicious-include)\n' % m for m in members)
            command = command.replace(self.entries[members[0]]['file'], source)
        with open(os.path.join(folder, 'compile_commands.json'), 'w', encoding='utf-8') as f:
            json.dump([{**self.entries[members[0]], 'file': source, 'command': command}], f)
        result = subprocess.run(
            ['clang-tidy', '--quiet', '-p', folder, '--header-filter=' + re.escape(self.root) + '/.*|.*/edge_mcl/.*',
             '--config-file=' + os.path.join(self.root, '.clang-tidy'), source],
            capture_output=True, text=True, check=False)
        return result.returncode, result.stdout

    def check(self, number, members):
        started = time.monotonic()
        status, text = self.run('group%d' % number, members)
        if len(members) > 1 and 'clang-diagnostic-' in text:  # errors, or shadowed names
            results = [self.run('group%d-%d' % (number, k), [m]) for k, m in enumerate(members)]
            status = max(s for s, _ in results)
            text = ''.join(t for s, t in results if s)
        return members, status, text, time.monotonic() - started


def main():
    build, files = sys.argv[1], [os.path.realpath(f) for f in sys.argv[2:]]
    root = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
    database = os.path.join(build, 'compile_commands.json')
    if not os.path.isfile(database):
        print('clang-tidy: %s is not a configured build directory' % build)
        return 1
    with open(database, encoding='utf-8') as f:
        entries = {os.path.realpath(e['file']): e for e in json.load(f)}
    wanted = [f for f in files if f in entries]
    groups = groups_of(wanted)
    print('lint: clang-tidy on %d files' % len(wanted), flush=True)
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        tidy = Tidy(entries, folder, root)
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            jobs = [pool.submit(tidy.check, k, g) for k, g in enumerate(groups)]
            for job in concurrent.futures.as_completed(jobs):
                members, status, text, seconds = job.result()
                names = ' '.join(os.path.relpath(m, root) for m in members)
                if os.environ.get('EDGE_MCL_TIDY_TIMES'):
                    print('%4.0f s %s' % (seconds, names), flush=True)
                if status != 0:
                    failed += 1
                    print('%s\n%s' % (names, text), flush=True)
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main())
