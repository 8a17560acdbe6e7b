"""``python -m reliability.flooder HZ SECONDS``: commands on `u` as fast as told, or as can be."""

import sys
import time

import rclpy
from std_msgs.msg import Float64

from pneu_rig_ros.records.cdr import pack_float64


def main() -> None:
    """Publish in lumps of one millisecond."""
    rate, seconds = float(sys.argv[1]), float(sys.argv[2])
    rclpy.init()
    node = rclpy.create_node('flooder')
    publisher, message = node.create_publisher(Float64, 'u', 10), pack_float64(0.34)
    while publisher.get_subscription_count() < 2:
        time.sleep(0.01)
    start, sent = time.monotonic(), 0
    while (elapsed := time.monotonic() - start) < seconds:
        for _ in range(int(elapsed * rate) - sent):
            publisher.publish(message)
            sent += 1
        time.sleep(0.001)
    rclpy.shutdown()


if __name__ == '__main__':
    main()
