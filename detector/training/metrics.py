"""Computes IoU, precision and recall of a segmentation from the counts of all pixels."""
import numpy as np


class Confusion:
    """Confusion matrix of pixels: rows are the true classes, columns the found classes."""

    def __init__(self, classes):
        self.counts = np.zeros((classes, classes), np.int64)

    def add(self, found, truth):
        """Counts the pixels of one image. Both arrays hold class numbers."""
        n = len(self.counts)
        self.counts += np.bincount(truth.astype(np.int64).ravel() * n + found.astype(np.int64).ravel(),
                                   minlength=n * n).reshape(n, n)

    def summary(self, names):
        """Returns the figures as a dict. Class 0 is the background, all others are movable."""
        c = self.counts.astype(float)

        def ratio(part, whole):
            return round(float(part / whole), 4) if whole > 0 else None

        hit = c[1:, 1:].sum()  # movable pixels found as movable, also with a wrong class
        result = {"movable_iou": ratio(hit, c.sum() - c[0, 0]),
                  "movable_precision": ratio(hit, c[:, 1:].sum()),
                  "movable_recall": ratio(hit, c[1:].sum())}
        for k, name in enumerate(names):
            if k > 0:
                result[name] = {"iou": ratio(c[k, k], c[k].sum() + c[:, k].sum() - c[k, k]),
                                "precision": ratio(c[k, k], c[:, k].sum()),
                                "recall": ratio(c[k, k], c[k].sum()),
                                # Share of the class that is masked, also with a wrong class.
                                "masked": ratio(c[k, 1:].sum(), c[k].sum())}
        return result
