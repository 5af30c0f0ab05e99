"""Writes the results of a soak as a page."""
import os
import statistics
import time


def quantile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def faultTable(recoveries):
    yield '| fault | times | tracks again | s of flight until then: median | 95 % | most |'
    yield '|---|---|---|---|---|---|'
    names = sorted({r.fault for r in recoveries})
    for name in names + ['all']:
        these = [r for r in recoveries if name in (r.fault, 'all')]
        back = [r.flight for r in these if r.flight is not None]
        figures = ['%.1f' % f for f in (statistics.median(back), quantile(back, 0.95), max(back))
                   ] if back else ['', '', '']
        yield '| %s | %d | %d | %s |' % (name, len(these), len(back), ' | '.join(figures))


def silentTable(silent):
    """Table of wrong poses in the state tracking, by the last fault before them."""
    yield '| after | images | farthest, m | most turned, degrees | stamps, s |'
    yield '|---|---|---|---|---|'
    for fault in sorted({s.fault for s in silent}):
        these = [s for s in silent if s.fault == fault]
        yield '| %s | %d | %.2f | %.1f | %.1f to %.1f |' % (
            fault, len(these), max(s.metres for s in these), max(s.degrees for s in these),
            these[0].stamp, these[-1].stamp)


def memoryTable(nodes):
    """Table of the longest life of each node, because a leak shows best there."""
    yield '| node | lives | longest, min | MB after 1 min | half way | at its end | most | ' \
          'files, threads: after 1 min | at its end |'
    yield '|---|---|---|---|---|---|---|---|---|'
    for node in nodes.values():
        life = node.longestLife()
        if not life:
            continue
        early = next((m for m in life if m[0] >= 60), life[-1])
        half = next(m for m in life if m[0] >= life[-1][0] / 2)
        last = life[-1]
        megabytes = ['%.0f' % (m[1] / 1024)
                     for m in (early, half, last, max(life, key=lambda m: m[1]))]
        yield '| %s | %d | %.0f | %s | %d, %d | %d, %d |' % (
            node.name, len(node.lives), last[0] / 60, ' | '.join(megabytes), early[2], early[3],
            last[2], last[3])


def writeReport(soak, file):
    """Writes and prints the page.

    @return exit code: 0 when no node crashed and the pose was tracked again after every fault
    """
    a, judge = soak.arguments, soak.judge
    crashes = [(n.name, c) for n in soak.nodes.values() for c in n.crashes]
    lost = [r for r in soak.recoveries if r.flight is None]
    lines = ['# Soak', '',
             '%.0f minutes of %s, model %s, seed %d, %g images a second, %d particles, cues: %s.' % (
                 (time.time() - soak.began) / 60, os.path.basename(a.bag),
                 os.path.basename(a.model), a.seed, a.rate, a.particles,
                 a.cues), '',
             '* crashes: %d' % len(crashes)]
    lines += ['  * %s %s' % c for c in crashes]
    lines += ['* faults: %d, after %d of them it did not track again within %g s' % (
        len(soak.recoveries), len(lost), a.patience)]
    lines += ['  * %.1f min: %s' % (r.at, r.fault) for r in lost]
    lines += ['* images: %d sent, %d of them tracked; %d of those had an error of more than 0.25 m or '
              '5 degrees (later than 2 s after the robot was carried elsewhere)' % (
                  soak.feeder.sent, judge.tracking, len(judge.silent))]
    lines += ['', '## Faults', ''] + list(faultTable(soak.recoveries))
    if judge.silent:
        lines += ['', '## Tracking, and wrong', ''] + list(silentTable(judge.silent))
    lines += ['', '## Memory', ''] + list(memoryTable(soak.nodes))
    text = '\n'.join(lines) + '\n'
    with open(file, 'w') as f:
        f.write(text)
    with open(os.path.join(os.path.dirname(file), 'processes.csv'), 'w') as f:
        f.write('node,life,age_s,resident_kb,files,threads\n')
        for node in soak.nodes.values():
            f.writelines(line + '\n' for line in node.figures())
    print('\n' + text)
    return 1 if crashes or lost else 0
