"""A controller of your own: listen to `joint_states`, publish `u` [V]."""

import signal

import rclpy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

TARGET, GAIN, DAMPING = 0.1, 200.0, 70.0  # m, V/m, V*s/m

stopped: list[int] = []  # by Ctrl-C: KeyboardInterrupt may end as another error within rclpy
signal.signal(signal.SIGINT, lambda number, _: stopped.append(number))
rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node('own_controller')
command = node.create_publisher(Float64, 'u', 10)


def control(sample: JointState) -> None:
    """Answer a sample with a command."""
    error, velocity = TARGET - sample.position[0], sample.velocity[0]
    command.publish(Float64(data=GAIN * error - DAMPING * velocity))


node.create_subscription(JointState, 'joint_states', control, 10)
while not stopped:
    rclpy.spin_once(node, timeout_sec=0.1)
