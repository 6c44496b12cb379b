"""What a serialised message says on the wire is what rclpy would have said of the same numbers."""

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.nodes.serialized import NumberPublisher, SerializedPublisher

pytestmark = pytest.mark.processes


def topics(bench, kind, name):
    """A publisher, and what a subscriber hears of it, once they have found each other."""
    heard = bench.listen(name, kind)
    publisher = bench.node.create_publisher(kind, name, QoSProfile(depth=1000))
    bench.until(publisher.get_subscription_count, 'the subscriber found no publisher')
    return publisher, heard


def joints(count):
    message = JointState(name=[f'joint_{"x" * k}' for k in range(count)])
    message.position, message.velocity, message.effort = ([0.0] * count for _ in range(3))
    return message


@pytest.mark.parametrize('value', [0.0, -1.5, 5e-324, float('inf')])
def test_a_number(bench, value):
    publisher, heard = topics(bench, Float64, f'number_{abs(hash(value))}')
    NumberPublisher(publisher).send(value)
    bench.until(lambda: heard, 'the number was not heard')
    assert heard.last == Float64(data=value)


@pytest.mark.parametrize('frame', ['', 'm', 'tcp_muscle', 'a_longer_name'])
def test_fields_and_stamps_whatever_the_length_of_the_names(bench, frame):
    """Strings come before the numbers and move them."""
    publisher, heard = topics(bench, Temperature, f'thermometer{frame}')
    message = Temperature(temperature=12.0, variance=0.25)
    message.header.frame_id = frame
    serialized = SerializedPublisher(publisher, message)
    serialized.numbers('temperature')[0] = 71.5
    serialized.stamp()[0], serialized.stamp()[1] = 1_700_000_000, 999_999_999
    serialized.publish()
    bench.until(lambda: heard, 'the message was not heard')
    wanted = Temperature(temperature=71.5, variance=0.25)
    wanted.header.frame_id = frame
    wanted.header.stamp.sec, wanted.header.stamp.nanosec = 1_700_000_000, 999_999_999
    assert heard.last == wanted
    assert message.temperature == 12.0  # the message given is as it was


@pytest.mark.parametrize('count', [1, 3, 16])
def test_sequences(bench, count):
    publisher, heard = topics(bench, JointState, f'joints_{count}')
    wanted = joints(count)
    serialized = SerializedPublisher(publisher, joints(count))
    for step, field in enumerate(('position', 'velocity', 'effort'), 1):
        numbers = serialized.numbers(field)
        assert len(numbers) == count
        for k in range(count):
            numbers[k] = step + 0.1 * k
        setattr(wanted, field, numbers.tolist())
    serialized.publish()
    bench.until(lambda: heard, 'the message was not heard')
    assert heard.last == wanted


def test_a_stamp_alone(bench):
    publisher, heard = topics(bench, Clock, 'times')
    serialized = SerializedPublisher(publisher, Clock())
    serialized.stamp()[0], serialized.stamp()[1] = 17, 5
    serialized.publish()
    bench.until(lambda: heard, 'the message was not heard')
    assert (heard.last.clock.sec, heard.last.clock.nanosec) == (17, 5)
