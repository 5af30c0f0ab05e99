"""Makes batches of randomly varied training images. The same seed and step give the same batch."""
import os
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np

cv2.setNumThreads(1)


class Images:
    """Reads the images and labels that edge_mcl_training_images wrote into a folder."""

    def __init__(self, directory):
        self.directory = directory
        self.names = sorted(f[:-4] for f in os.listdir(directory)
                            if f.endswith(".png") and not f.startswith("part_"))
        if not self.names:
            raise SystemExit(f"{directory}: no images")

    def __len__(self):
        return len(self.names)

    def read(self, i):
        path = os.path.join(self.directory, self.names[i])
        return cv2.imread(path + ".jpg"), cv2.imread(path + ".png", cv2.IMREAD_GRAYSCALE)


def placed(image, label, width, height, r, zoom):
    """Returns a zoomed part of image and label, mirrored with probability 0.5.

    Pixels outside the image become grey (114) with the label 0 (background). width and height are the
    size of the result in pixels. zoom is a pair: least and largest factor.
    """
    scale = width / image.shape[1] * np.exp(r.uniform(np.log(zoom[0]), np.log(zoom[1])))
    aspect = np.exp(r.uniform(-0.1, 0.1))
    sx, sy = scale * aspect, scale / aspect
    wide, high = image.shape[1] * sx, image.shape[0] * sy
    dx = r.uniform(min(0, width - wide), max(0, width - wide))
    dy = r.uniform(min(0, height - high), max(0, height - high))
    move = np.array([[sx, 0, dx], [0, sy, dy]])
    if r.random() < 0.5:
        move[0] = [-sx, 0, width - dx]
    if scale < 0.75:
        image = cv2.blur(image, (2, 2))
    return (cv2.warpAffine(image, move, (width, height), flags=cv2.INTER_LINEAR, borderValue=(114,) * 3),
            cv2.warpAffine(label, move, (width, height), flags=cv2.INTER_NEAREST, borderValue=0))


def spoiled(image, r):
    """Changes exposure and colour and adds blur, noise and compression, as in a real camera."""
    ramp = np.linspace(0, 1, 256)
    gain = np.exp(r.normal(0, 0.2)) * np.exp(r.normal(0, 0.06, 3))
    gamma, lift = np.exp(r.normal(0, 0.2)), r.uniform(-0.04, 0.06)
    table = np.clip(255 * (gain[None] * ramp[:, None] ** gamma + lift), 0, 255).astype(np.uint8)
    image = cv2.LUT(image, table[None])
    if r.random() < 0.25:
        grey = cv2.cvtColor(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)
        share = 1.0 if r.random() < 0.4 else r.uniform(0.2, 0.9)
        image = cv2.addWeighted(grey, share, image, 1 - share, 0)
    if r.random() < 0.2:
        length = int(r.integers(2, 6))
        image = (cv2.blur(image, (length, 1) if r.random() < 0.5 else (1, length))
                 if r.random() < 0.5 else cv2.GaussianBlur(image, (0, 0), r.uniform(0.4, 1.3)))
    if r.random() < 0.5:
        sigma = r.uniform(1, 6)
        noise = r.normal(0, sigma, image.shape).astype(np.float32)
        image = np.clip(image + noise, 0, 255).astype(np.uint8)
    if r.random() < 0.25:
        coded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, int(r.integers(35, 90))])[1]
        image = cv2.imdecode(coded, cv2.IMREAD_COLOR)
    return image


def training_batch(images, seed, step, size, width, height, zoom):
    """Returns `size` images (N, H, W, 3) and labels (N, H, W) as bytes, chosen and varied at random."""
    r = np.random.default_rng([seed, step])
    colors, labels = [], []
    for i in r.integers(0, len(images), size):
        image, label = images.read(int(i))
        image, label = placed(image, label, width, height, r, zoom)
        colors.append(spoiled(image, r))
        labels.append(label)
    return np.stack(colors), np.stack(labels)


def ahead(function, first, last):
    """Yields (step, function(step)) for first to last - 1. The next call runs ahead in a thread."""
    with ThreadPoolExecutor(1) as worker:
        waiting = worker.submit(function, first) if first < last else None
        for step in range(first, last):
            result = waiting.result()
            waiting = worker.submit(function, step + 1) if step + 1 < last else None
            yield step, result
