"""Defines the default network: a small encoder-decoder that classifies every pixel.

It has inverted residuals (Sandler et al. 2018, arXiv:1801.04381) with plain ReLU, because OpenCV 4.6
cannot read a clipped ReLU. A summary of the whole image is added at a coarse level, as in
arXiv:1706.05587. Skip connections bring the outlines back. The scores have half the resolution of the
input.
"""
import torch.nn.functional as F
from torch import nn

CLASSES = ["background", "person", "sofa", "chair", "computer", "screen"]
WIDTH, HEIGHT = 320, 240
# The input of the network is (colour - MEAN) / SPREAD. Colours are 0 to 1, blue green red.
MEAN, SPREAD = 0.45, 0.25


def convolution(inputs, outputs, kernel=1, stride=1, groups=1, dilation=1, active=True):
    """Returns a convolution with batch normalization and, if active, ReLU."""
    layers = [nn.Conv2d(inputs, outputs, kernel, stride, dilation * (kernel // 2), dilation, groups,
                        bias=False), nn.BatchNorm2d(outputs)]
    if active:
        layers.append(nn.ReLU(inplace=True))
    return nn.Sequential(*layers)


class InvertedResidual(nn.Module):
    """Block of arXiv:1801.04381: widen, convolve every channel, narrow, add the input."""

    def __init__(self, inputs, outputs, stride=1, widening=3, dilation=1):
        super().__init__()
        middle = inputs * widening
        self.body = nn.Sequential(
            convolution(inputs, middle),
            convolution(middle, middle, 3, stride, middle, dilation),
            convolution(middle, outputs, active=False))
        self.keeps = stride == 1 and inputs == outputs

    def forward(self, x):
        return x + self.body(x) if self.keeps else self.body(x)


class Residual(nn.Module):
    """Adds a 3x3 convolution of the rectified input to the input."""

    def __init__(self, channels):
        super().__init__()
        self.body = nn.Sequential(nn.ReLU(), convolution(channels, channels, 3, active=False))

    def forward(self, x):
        return x + self.body(x)


class Network(nn.Module):
    """Maps images (N, 3, H, W) to scores before softmax (N, classes, H/2, W/2)."""

    def __init__(self, classes=len(CLASSES)):
        super().__init__()
        # The first levels are dense convolutions: on large maps widening costs more than it gains.
        self.to_half = convolution(3, 16, 3, 2)
        self.to_quarter = nn.Sequential(convolution(16, 32, 3, 2), Residual(32))
        self.to_eighth = nn.Sequential(convolution(32, 48, 3, 2), Residual(48), Residual(48))
        self.to_sixteenth = nn.Sequential(
            InvertedResidual(48, 96, 2, 4), InvertedResidual(96, 96), InvertedResidual(96, 96, dilation=2),
            InvertedResidual(96, 96, dilation=4), InvertedResidual(96, 96, dilation=2),
            InvertedResidual(96, 96, dilation=4), InvertedResidual(96, 96))
        # This level sees objects that fill the image as a whole.
        self.to_thirtysecond = nn.Sequential(
            InvertedResidual(96, 144, 2), InvertedResidual(144, 144), InvertedResidual(144, 144, dilation=2),
            InvertedResidual(144, 144))
        self.from_thirtysecond = convolution(144, 96, active=False)
        # This level starts with weight 0, so that training can start from a network without it.
        nn.init.zeros_(self.from_thirtysecond[1].weight)
        self.summary = nn.Sequential(nn.AdaptiveAvgPool2d(1), nn.Conv2d(96, 96, 1), nn.ReLU(inplace=True))
        self.deep = convolution(96, 48, active=False)
        self.from_eighth = convolution(48, 48, active=False)
        self.at_eighth = nn.Sequential(Residual(48), convolution(48, 32, active=False))
        self.from_quarter = convolution(32, 32, active=False)
        self.at_quarter = nn.Sequential(Residual(32), convolution(32, 16, active=False))
        self.from_half = convolution(16, 16, active=False)
        self.at_half = nn.Sequential(nn.ReLU(inplace=True), convolution(16, 16, 3, groups=16),
                                     nn.Conv2d(16, classes, 1))

    def forward(self, x):
        half = self.to_half(x)
        quarter = self.to_quarter(half)
        eighth = self.to_eighth(quarter)
        deep = self.to_sixteenth(eighth)
        coarsest = self.from_thirtysecond(self.to_thirtysecond(deep))
        # The size is given instead of a factor: for 320x240 the coarsest level is 10x8, and twice
        # its size has one row too many.
        coarsest = F.interpolate(coarsest, size=tuple(int(n) for n in deep.shape[2:]), mode="bilinear",
                                 align_corners=False)
        deep = self.deep(deep + coarsest + self.summary(deep))
        x = self.at_eighth(larger(deep) + self.from_eighth(eighth))
        x = self.at_quarter(larger(x) + self.from_quarter(quarter))
        return self.at_half(larger(x) + self.from_half(half))


def larger(x):
    """Doubles width and height of the maps."""
    return F.interpolate(x, scale_factor=2.0, mode="bilinear", align_corners=False)


def normalised(images):
    """Converts byte images (N, H, W, 3) to the network's input (N, 3, H, W)."""
    return ((images.permute(0, 3, 1, 2).float() / 255) - MEAN) / SPREAD
