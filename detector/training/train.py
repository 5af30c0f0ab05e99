"""Trains the default network.

    train.py DATA_DIR RUN_DIR [--small-steps N] [--full-steps N] [--start WEIGHTS]

DATA_DIR holds train/ and test/ as edge_mcl_training_images writes them. RUN_DIR gets log.csv and
checkpoint.pt. An interrupted run continues from the checkpoint. At the end RUN_DIR gets network.onnx,
network.pt (weights from which another training can start) and metrics.json.
The training starts at 160x128, where a step takes a fifth of the time, and continues at 320x240.
"""
import argparse
import json
import os
import sys
import time

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")  # without it, threads that wait keep shared cores busy
import cv2  # noqa: E402
import numpy as np  # noqa: E402
import torch  # noqa: E402
import torch.nn.functional as F  # noqa: E402

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from data import Images, ahead, training_batch  # noqa: E402
from metrics import Confusion  # noqa: E402
from network import CLASSES, HEIGHT, WIDTH, Network, normalised  # noqa: E402

# Weights of the classes in the cross-entropy. Rare classes weigh more, by about the root of their
# rarity.
WEIGHTS = torch.tensor([0.5, 1.5, 1.2, 1.8, 2.2, 1.8])


def dice_loss(probabilities, truth):
    """Returns half the mean of 1 - Dice over the movable classes, plus 1 - Dice of all together.

    Both arrays are (N, classes, H, W). The counts are sums over the batch.
    """
    overlap = (probabilities * truth).sum((0, 2, 3))
    total = probabilities.sum((0, 2, 3)) + truth.sum((0, 2, 3))
    by_class = 1 - (2 * overlap + 50) / (total + 50)
    p, t = 1 - probabilities[:, 0], 1 - truth[:, 0]
    together = 1 - (2 * (p * t).sum() + 50) / (p.sum() + t.sum() + 50)
    return 0.5 * by_class[1:].mean() + together


def loss_of(scores, labels):
    """Returns cross-entropy plus dice loss. scores: (N, classes, H/2, W/2); labels: (N, H, W)."""
    labels = labels[:, ::2, ::2]  # the scores have half the resolution
    truth = F.one_hot(labels, len(CLASSES)).permute(0, 3, 1, 2).float()
    return F.cross_entropy(scores, labels, WEIGHTS) + dice_loss(scores.softmax(1), truth)


def learning_rate(step, total, peak):
    """Returns the learning rate: it rises for 5 % of the steps and then falls along a cosine."""
    if step < 0.05 * total:
        return peak * (step + 1) / (0.05 * total)
    return peak * (0.5 + 0.5 * np.cos(np.pi * (step - 0.05 * total) / (0.95 * total))) + 1e-5


@torch.no_grad()
def evaluate(network, images, count, small=False):
    """Returns the figures of Confusion.summary() over the first `count` images.

    small: the images are halved to 160x128, as in the first part of the training.
    """
    network.eval()
    confusion = Confusion(len(CLASSES))
    for i in range(min(count, len(images))):
        color, label = images.read(i)
        if small:
            color = cv2.copyMakeBorder(cv2.resize(color, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA),
                                       0, 8, 0, 0, cv2.BORDER_CONSTANT, value=(114,) * 3)
            label = cv2.copyMakeBorder(label[::2, ::2], 0, 8, 0, 0, cv2.BORDER_CONSTANT, value=0)
        scores = network(normalised(torch.from_numpy(color[None])).contiguous(memory_format=torch.channels_last))
        scores = F.interpolate(scores, scale_factor=2.0, mode="bilinear", align_corners=False)
        confusion.add(scores[0].argmax(0).numpy(), label)
    network.train()
    return confusion.summary(CLASSES)


def averaged(average, network, step):
    """Updates a running mean of the weights, which generalises better than the last weights."""
    keep = min(0.998, (1 + step) / (10 + step))
    with torch.no_grad():
        for name, value in network.state_dict().items():
            if value.dtype.is_floating_point:
                average[name].mul_(keep).add_(value, alpha=1 - keep)
            else:
                average[name].copy_(value)


def export(network, path):
    """Writes the network as ONNX."""
    network.eval()
    torch.onnx.export(network, torch.zeros(1, 3, HEIGHT, WIDTH), path, opset_version=12,
                      input_names=["image"], output_names=["scores"])


@torch.no_grad()
def agreement(network, onnx, images, count):
    """Returns the mean IoU between the movable pixels found by OpenCV and by PyTorch."""
    net, overlaps = cv2.dnn.readNetFromONNX(onnx), []
    for i in range(min(count, len(images))):
        inputs = normalised(torch.from_numpy(images.read(i)[0][None]))
        net.setInput(inputs.numpy())
        a, b = net.forward("scores")[0].argmax(0) > 0, network(inputs)[0].argmax(0).numpy() > 0
        overlaps.append((a & b).sum() / (a | b).sum() if (a | b).any() else 1.0)
    return round(float(np.mean(overlaps)), 5)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("data")
    arguments.add_argument("run")
    arguments.add_argument("--small-steps", type=int, default=2200, help="steps of 32 images at 160x128")
    arguments.add_argument("--full-steps", type=int, default=2600, help="steps of 16 images at 320x240")
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--peak-rate", type=float, default=3e-3,
                           help="largest learning rate; use less when --start gives good weights")
    arguments.add_argument("--start", help="file with the first weights, e.g. ../models/indoor.pt")
    arguments.add_argument("--threads", type=int, default=2)
    options = arguments.parse_args()

    torch.manual_seed(options.seed)
    torch.set_num_threads(options.threads)
    os.makedirs(options.run, exist_ok=True)
    train, test = Images(f"{options.data}/train"), Images(f"{options.data}/test")
    network = Network().to(memory_format=torch.channels_last)
    print(f"{sum(p.numel() for p in network.parameters())} parameters, {len(train)} + {len(test)} images")
    if options.start:
        lacking = network.load_state_dict(torch.load(options.start), strict=False)
        if lacking.unexpected_keys:
            raise SystemExit(f"{options.start}: the weights belong to another network: {', '.join(lacking.unexpected_keys)}")
        if lacking.missing_keys:
            print(f"{options.start} lacks {len(lacking.missing_keys)} of the network's tensors")
    average = {k: v.clone() for k, v in network.state_dict().items()}
    optimizer = torch.optim.AdamW(network.parameters(), weight_decay=1e-2)
    total, first = options.small_steps + options.full_steps, 0
    checkpoint = f"{options.run}/checkpoint.pt"
    if os.path.exists(checkpoint):
        saved = torch.load(checkpoint)
        network.load_state_dict(saved["network"])
        optimizer.load_state_dict(saved["optimizer"])
        average, first = saved["average"], saved["step"]
        print(f"continues at step {first}")

    def batch(step):
        small = step < options.small_steps
        return training_batch(train, options.seed, step, 32 if small else 16,
                              160 if small else WIDTH, 128 if small else HEIGHT,
                              (0.9, 1.7) if small else (0.75, 1.5))

    log = open(f"{options.run}/log.csv", "a", buffering=1)
    losses, began = [], time.time()
    for step, (colors, labels) in ahead(batch, first, total):
        for group in optimizer.param_groups:
            group["lr"] = learning_rate(step, total, options.peak_rate)
        inputs = normalised(torch.from_numpy(colors)).contiguous(memory_format=torch.channels_last)
        loss = loss_of(network(inputs), torch.from_numpy(labels).long())
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 2.0)
        optimizer.step()
        averaged(average, network, step)
        losses.append(loss.item())
        if (step + 1) % 50 == 0:
            print(f"step {step + 1} of {total}  loss {np.mean(losses[-50:]):.3f}  "
                  f"{time.time() - began:.0f} s", flush=True)
            log.write(f"{step + 1},{np.mean(losses[-50:]):.4f}\n")
        if (step + 1) % 400 == 0 or step + 1 == total:
            torch.save({"network": network.state_dict(), "optimizer": optimizer.state_dict(),
                        "average": average, "step": step + 1}, checkpoint + ".part")
            os.replace(checkpoint + ".part", checkpoint)
            judged = Network().to(memory_format=torch.channels_last)
            judged.load_state_dict(average)
            print(f"step {step + 1}: {evaluate(judged, test, 200, step < options.small_steps)}", flush=True)

    network.load_state_dict(average)
    metrics = evaluate(network, test, len(test))
    torch.save(network.state_dict(), f"{options.run}/network.pt")
    export(network, f"{options.run}/network.onnx")
    metrics["opencv_agreement"] = agreement(network, f"{options.run}/network.onnx", test, 50)
    with open(f"{options.run}/metrics.json", "w") as out:
        json.dump(metrics, out, indent=1)
    print(json.dumps(metrics, indent=1))


if __name__ == "__main__":
    main()
