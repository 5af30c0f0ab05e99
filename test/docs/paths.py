#!/usr/bin/env python3
"""Every path of the tree that a document names exists, and so does the target of every link.

usage: paths.py SOURCE_DIR
"""
import glob
import os
import re
import sys

ROOMS = ('apps', 'bench', 'cfg', 'cmake', 'comparison', 'config', 'core', 'detector', 'docs', 'gpu', 'launch',
         'localization', 'maps', 'mrpt_plugins', 'msg', 'nodes', 'scripts', 'sim', 'srv', 'test', 'viewer')
NAME = re.compile(r'`((?:%s)/[^`\s]*)`' % '|'.join(ROOMS))
LINK = re.compile(r'\]\(([^)#]+)(?:#[^)]*)?\)')


def expanded(path):
    """a/{b,c}.h as a/b.h and a/c.h."""
    braces = re.search(r'\{([^}]*)\}', path)
    if not braces:
        return [path]
    return [p for part in braces.group(1).split(',')
            for p in expanded(path[:braces.start()] + part.strip() + path[braces.end():])]


def exists(root, path):
    path = path.rstrip('.,;:')
    if '<' in path or 'NAME' in path:  # a pattern, as `test/<folder>/<unit>_test.cpp`
        return True
    here = os.path.join(root, path)
    # A unit may be named without the endings of its files.
    return bool(glob.glob(here) or glob.glob(here + '.*'))


def main():
    root = sys.argv[1]
    faults, paths = [], 0
    documents = [p for pattern in ('*.md', 'docs/**/*.md', 'bench/*.md', 'detector/models/*.md')
                 for p in glob.glob(os.path.join(root, pattern), recursive=True)]
    for document in documents:
        with open(document, encoding='utf-8') as f:
            text = f.read()
        name = os.path.relpath(document, root)
        for path in NAME.findall(text):
            for one in expanded(path):
                paths += 1
                if not exists(root, one):
                    faults.append('%s names %s' % (name, one))
        for link in LINK.findall(text):
            if re.match(r'[a-z]+:', link):
                continue
            paths += 1
            if not os.path.exists(os.path.join(os.path.dirname(document), link)):
                faults.append('%s links to %s' % (name, link))
    for fault in faults:
        print(fault + ', which does not exist')
    print('%d paths in %d documents, %d missing' % (paths, len(documents), len(faults)))
    return 1 if faults or paths < 50 else 0


if __name__ == '__main__':
    sys.exit(main())
