"""Publishes a recorded flight image by image, for any time, with faults where wanted."""
import copy
import threading
import time

import numpy
import rosbag
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage


def matrix(translation, rotation):
    """Makes a 4x4 matrix of the vector and the quaternion of a message."""
    x, y, z, w = rotation.x, rotation.y, rotation.z, rotation.w
    result = numpy.eye(4)
    result[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    result[:3, 3] = [translation.x, translation.y, translation.z]
    return result


def difference(a, b):
    """Distance in metres and angle in degrees between two 4x4 matrices."""
    relative = numpy.linalg.inv(a) @ b
    cosine = (numpy.trace(relative[:3, :3]) - 1) / 2
    return (float(numpy.linalg.norm(relative[:3, 3])),
            float(numpy.degrees(numpy.arccos(min(1, max(-1, cosine))))))


class Frame:
    def __init__(self, messages):
        self.image, self.info = messages['image'], messages['info']
        self.depth, self.mask = messages.get('depth'), messages.get('mask')
        self.odometry = messages['tf'].transforms[0]
        truth = messages['truth'].pose
        self.truth = matrix(truth.position, truth.orientation)
        transform = self.odometry.transform
        self.T_odom_base = matrix(transform.translation, transform.rotation)

    def odometryAt(self, stamp, T_odom_odom):
        """Returns odometry of this moment with another stamp and another origin."""
        message = copy.deepcopy(self.odometry)
        message.header.stamp = stamp
        T = T_odom_odom @ self.T_odom_base
        to = message.transform
        to.translation.x, to.translation.y, to.translation.z = T[:3, 3]
        to.rotation.x, to.rotation.y, to.rotation.z, to.rotation.w = quaternion(T[:3, :3])
        return TFMessage([message])


def readFrames(bag_file, every):
    """Returns every n-th moment of a bag, the initial pose and the mounting of the camera."""
    names = {'/camera/image_raw': 'image', '/camera/camera_info': 'info', '/camera/mask': 'mask',
             '/camera/depth/image_raw': 'depth', '/ground_truth': 'truth', '/tf': 'tf'}
    moments, others = {}, {}
    with rosbag.Bag(bag_file) as bag:
        for topic, message, stamp in bag.read_messages():
            if topic in names:
                moments.setdefault(stamp.to_nsec(), {})[names[topic]] = message
            elif topic in ('/initialpose', '/tf_static'):
                others[topic] = message
    whole = [moments[k] for k in sorted(moments)
             if {'image', 'info', 'truth', 'tf'} <= moments[k].keys()]
    if not whole or '/tf_static' not in others or '/initialpose' not in others:
        raise SystemExit('%s: not a flight of edge-mcl simulate or edge-mcl bag with truth and odometry'
                         % bag_file)
    frames = [Frame(m) for m in whole[::every]]
    return frames, others['/initialpose'], others['/tf_static']


class FlightFeeder:
    """Flies the recording to and fro, so that the motion has no jumps except those of jump().

    `withhold` names the data that are not published: image, info, depth, odometry. `spoil` changes
    an image before it is sent. `truth_at` maps the nanoseconds of a stamp to the true 4x4 T_map_base.
    """

    def __init__(self, bag_file, images_per_second, every=2):
        self.frames, self.initial_pose, mounting = readFrames(bag_file, every)
        first, second = self.frames[0].image.header.stamp, self.frames[1].image.header.stamp
        self.step = (second - first).to_sec()  # s of flight between images
        self.period = 1 / images_per_second    # s of the wall clock between images
        self.withhold, self.spoil = set(), None
        self.truth_at, self.lock = {}, threading.Lock()
        self.now, self.at, self.way, self.sent = 100.0, 0, 1, 0
        self.T_odom_odom = numpy.eye(4)  # from the odometry frame of the recording to that of the robot
        self.due = time.time()
        self.clock = rospy.Publisher('/clock', Clock, queue_size=10)
        self.tf = rospy.Publisher('/tf', TFMessage, queue_size=100)
        self.tf_static = rospy.Publisher('/tf_static', TFMessage, queue_size=1, latch=True)
        self.image = rospy.Publisher('/camera/image_raw', Image, queue_size=2)
        self.info = rospy.Publisher('/camera/camera_info', CameraInfo, queue_size=2)
        self.depth = rospy.Publisher('/camera/depth/image_raw', Image, queue_size=2)
        self.initial = rospy.Publisher('/initialpose', PoseWithCovarianceStamped, queue_size=1)
        self.tf_static.publish(mounting)

    def begin(self):
        """Publishes the initial pose, as a user does."""
        pose = copy.deepcopy(self.initial_pose)
        pose.header.stamp = rospy.Time.from_sec(self.now)
        self.initial.publish(pose)

    def fly(self):
        """Waits until the next image is due, and publishes it."""
        self.at += self.way
        if not 0 <= self.at < len(self.frames):
            self.way = -self.way
            self.at += 2 * self.way
        self.now += self.step
        wait = self.due - time.time()
        if wait > 0:
            time.sleep(wait)
        self.due = max(self.due + self.period, time.time())
        self.publish()

    def jump(self, frame, seconds, odometry_knows):
        """Goes on at another frame and time. If odometry does not know it, the robot was carried there."""
        if not odometry_knows:
            here = self.T_odom_odom @ self.frames[self.at].T_odom_base
            self.T_odom_odom = here @ numpy.linalg.inv(self.frames[frame].T_odom_base)
        self.at = frame
        self.now = max(10.0, self.now + seconds)
        with self.lock:
            self.truth_at.clear()

    def publish(self):
        frame, stamp = self.frames[self.at], rospy.Time.from_sec(self.now)
        with self.lock:
            self.truth_at[stamp.to_nsec()] = frame.truth
            while len(self.truth_at) > 1000:
                del self.truth_at[next(iter(self.truth_at))]
        self.clock.publish(Clock(stamp))
        if 'odometry' not in self.withhold:
            self.publishOdometry(frame, stamp)
        if 'info' not in self.withhold:
            self.send(self.info, frame.info, stamp)
        if frame.depth and 'depth' not in self.withhold:
            self.send(self.depth, frame.depth, stamp)
        if 'image' not in self.withhold:
            image = copy.copy(frame.image)
            if self.spoil:
                self.spoil(image)
            self.send(self.image, image, stamp)
            self.sent += 1

    def publishOdometry(self, frame, stamp):
        self.tf.publish(frame.odometryAt(stamp, self.T_odom_odom))

    @staticmethod
    def send(publisher, message, stamp):
        message = copy.copy(message)
        message.header = copy.copy(message.header)
        message.header.stamp = stamp
        publisher.publish(message)


def quaternion(rotation):
    """Quaternion x, y, z, w of a 3x3 rotation, from a dominant eigenvector (Bar-Itzhack 2000)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    k = numpy.array([[a - e - i, b + d, c + g, h - f],
                     [b + d, e - a - i, f + h, c - g],
                     [c + g, f + h, i - a - e, d - b],
                     [h - f, c - g, d - b, a + e + i]]) / 3
    return numpy.linalg.eigh(k)[1][:, -1]
