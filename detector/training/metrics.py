"""Figures of a segmentation, from the counts of all pixels."""
import numpy as np


class Confusion:
    def __init__(self, classes):
        self.counts = np.zeros((classes, classes), np.int64)  # truth by found

    def add(self, found, truth):
        n = len(self.counts)
        self.counts += np.bincount(truth.astype(np.int64).ravel() * n + found.astype(np.int64).ravel(),
                                   minlength=n * n).reshape(n, n)

    def summary(self, names):
        c = self.counts.astype(float)

        def ratio(part, whole):
            return round(float(part / whole), 4) if whole > 0 else None

        hit = c[1:, 1:].sum()  # movable found as movable, of whichever class
        result = {"movable_iou": ratio(hit, c.sum() - c[0, 0]),
                  "movable_precision": ratio(hit, c[:, 1:].sum()),
                  "movable_recall": ratio(hit, c[1:].sum())}
        for k, name in enumerate(names):
            if k > 0:
                result[name] = {"iou": ratio(c[k, k], c[k].sum() + c[:, k].sum() - c[k, k]),
                                "precision": ratio(c[k, k], c[:, k].sum()),
                                "recall": ratio(c[k, k], c[k].sum()),
                                # Masked, under whatever name.
                                "masked": ratio(c[k, 1:].sum(), c[k].sum())}
        return result
