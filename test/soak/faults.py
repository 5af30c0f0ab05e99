"""The faults of a soak test. Each fault begins, lasts for some images, and ends."""


def darken(image):
    image.data = bytes(len(image.data))


def truncate(image):
    image.data = image.data[:len(image.data) // 3]


class Fault:
    """`begin` and `end` are called with the soak. `images`: smallest and largest duration, in images."""

    def __init__(self, name, begin, end=None, images=(15, 75), weight=1):
        self.name, self.begin, self.end = name, begin, end or (lambda soak: None)
        self.images, self.weight = images, weight


def withheld(what):
    return Fault('no ' + what, lambda soak: soak.feeder.withhold.add(what),
                 lambda soak: soak.feeder.withhold.discard(what))


def spoiled(name, how):
    def begin(soak):
        soak.feeder.spoil = how

    def end(soak):
        soak.feeder.spoil = None
    return Fault(name, begin, end)


def jumped(name, seconds, odometry_knows):
    def begin(soak):
        soak.feeder.jump(soak.random.randrange(len(soak.feeder.frames)), seconds(soak.random),
                         odometry_knows)
    return Fault(name, begin, images=(0, 0))


def paused(node):
    return Fault(node + ' stopped', lambda soak: soak.nodes[node].pause(),
                 lambda soak: soak.nodes[node].resume())


def restarted(node, kill):
    def begin(soak):
        soak.nodes[node].end(kill)

    def end(soak):
        soak.nodes[node].start()
    return Fault('%s %s' % (node, 'killed' if kill else 'restarted'), begin, end, images=(0, 30))


def everyFault():
    """Returns two lists: faults that leave the processes alone, and faults that end a process."""
    gentle = [
        withheld('image'), withheld('info'), withheld('odometry'), withheld('depth'),
        spoiled('dark', darken), spoiled('truncated images', truncate),
        jumped('bag jumps ahead', lambda random: random.uniform(2, 20), True),
        jumped('bag jumps back', lambda random: -random.uniform(2, 20), True),
        jumped('carried elsewhere', lambda random: 0.0, False),
        paused('edge_mcl_localizer'), paused('edge_mcl_detector')]
    restarts = [restarted(node, kill)
                for node in ('edge_mcl_localizer', 'edge_mcl_detector', 'edge_mcl_viewer')
                for kill in (False, True)]
    return gentle, restarts
