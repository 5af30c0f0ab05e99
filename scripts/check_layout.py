#!/usr/bin/env python3
"""Checks which folder includes which, and the size of files and folders.

RANKS is the order of the folders. A file may include headers of its own folder and of folders with a
lower number. Folders with the same number do not include each other, except for those of one room in
SAME_ROOM. FORBIDDEN names headers of other libraries that a room must not include.
"""
import collections
import os
import re
import subprocess
import sys

RANKS = [
    ['core/base'],
    ['core/camera', 'core/mesh', 'core/image'],
    ['core/import', 'core/edges', 'core/depth'],
    ['core/likelihood', 'core/places', 'core/recordings'],
    ['core'],
    ['core/drawing'],
    ['gpu/math'],
    ['gpu/engine', 'gpu/workload'],
    ['gpu/emulation'],
    ['gpu/check', 'gpu/backend'],
    ['sim', 'detector', 'mapping'],
    ['detector/training', 'audit'],
    ['localization/filter', 'localization/lookup'],
    ['localization/search', 'localization/masks', 'localization/objects'],
    ['localization/tracking'],
    ['localization/recorded'],
    ['localization'],
    ['mrpt_plugins'],
    ['viewer/moments', 'comparison'],
    ['viewer/drawing'],
    ['viewer/scene'],
    ['viewer/output'],
    ['viewer/window'],
    ['nodes/messages', 'nodes/common'],
    ['nodes/bags', 'nodes/localizer', 'nodes/detector', 'nodes/mavros', 'nodes/openni2', 'nodes/simulator'],
    ['nodes/viewer'],
    ['apps'],
    ['apps/recordings', 'apps/experiments', 'apps/bench'],
    ['apps/mapping'],
    ['docs/examples/minimal', 'docs/examples/ros_node'],
]
RANK = {folder: rank for rank, folders in enumerate(RANKS) for folder in folders}
FORBIDDEN = [
    # Folders (regular expression), headers (regular expression), reason.
    (r'core(/|$)', r'ros/|mrpt/|cuda|edge_mcl/gpu/|[a-z0-9_]+_msgs/', 'core/ knows no ROS, MRPT, CUDA'),
    (r'gpu/(math|engine|emulation|workload|check)$', r'ros/|mrpt/|opencv|Eigen|tbb/|edge_mcl/core/',
     'this part of gpu/ needs a compiler and the CUDA toolkit only'),
    (r'localization(/|$)', r'ros/|mrpt/|[a-z0-9_]+_msgs/', 'localization/ knows no ROS and MRPT'),
    (r'(mrpt_plugins|viewer|comparison|detector|sim)(/|$)', r'ros/|[a-z0-9_]+_msgs/',
     'only nodes/ and apps/ know ROS'),
]
MOST_LINES, MOST_UNITS = 450, 16
INCLUDE = re.compile(r'^\s*#include\s*[<"]([^>"]+)[>"]', re.M)
SOURCE = re.compile(r'\.(h|cpp|cu|cuh)$')


def sources():
    listed = subprocess.check_output(
        ['git', 'ls-files', '--cached', '--others', '--exclude-standard'], text=True).split('\n')
    return [f for f in listed if os.path.isfile(f)]


def target(include):
    """The file in the tree that an include means, or None."""
    path = include[len('edge_mcl/'):] if include.startswith('edge_mcl/') else include
    return path if os.path.isfile(path) and SOURCE.search(path) else None


def check_includes(file, faults):
    folder = os.path.dirname(file)
    if folder.startswith('test'):
        return
    if folder not in RANK:
        faults.append('%s: folder %s is not in RANKS' % (file, folder))
        return
    with open(file, encoding='utf-8') as f:
        text = f.read()
    if file.endswith('.h') and '#pragma once' not in text and not file.endswith('-inl.h'):
        faults.append('%s: no #pragma once' % file)
    for include in INCLUDE.findall(text):
        for folders, headers, reason in FORBIDDEN:
            if re.match(folders, folder) and re.match(headers, include):
                faults.append('%s includes %s: %s' % (file, include, reason))
        other = target(include)
        if other is None:
            continue
        to = os.path.dirname(other)
        if to == folder or to.startswith('test'):
            continue
        if RANK.get(to, 99) >= RANK[folder]:
            faults.append('%s includes %s: %s is not below %s' % (file, include, to, folder))


def check_sizes(files, faults):
    units = collections.defaultdict(set)
    for file in files:
        if not re.search(r'\.(h|cpp|cu|cuh|py)$', file):
            continue
        with open(file, encoding='utf-8') as f:
            lines = sum(1 for _ in f)
        if lines > MOST_LINES:
            faults.append('%s has %d lines, at most %d are allowed' % (file, lines, MOST_LINES))
        if SOURCE.search(file):
            units[os.path.dirname(file)].add(os.path.splitext(os.path.basename(file))[0])
    for folder, names in sorted(units.items()):
        if len(names) > MOST_UNITS:
            faults.append('%s has %d units, at most %d are allowed' % (folder, len(names), MOST_UNITS))


def print_tree(files):
    rows = collections.defaultdict(lambda: [set(), 0])
    for file in files:
        if SOURCE.search(file):
            row = rows[os.path.dirname(file)]
            row[0].add(os.path.splitext(os.path.basename(file))[0])
            with open(file, encoding='utf-8') as f:
                row[1] += sum(1 for _ in f)
    for folder, (names, lines) in sorted(rows.items()):
        print('%-28s %3d units %6d lines' % (folder, len(names), lines))


def main():
    os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
    files = sources()
    if sys.argv[1:] == ['--tree']:
        print_tree(files)
        return 0
    faults = []
    for file in files:
        if SOURCE.search(file):
            check_includes(file, faults)
    check_sizes(files, faults)
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == '__main__':
    sys.exit(main())
