"""The twin tells its controller of the adopted model, and tells it again where it has begun anew."""

from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from tcp_muscle_ros.nodes.twin_controller import Believing

ADOPTED = 'improved.yaml'


class Controller:
    """Its parameter service, which takes whatever it is told; ``told`` keeps it."""

    service_name = '/worn/controller_node/set_parameters'

    def __init__(self):
        self.ready, self.told = True, []

    def service_is_ready(self):
        return self.ready

    def call_async(self, request):
        self.told.append(request.parameters[0].value.string_value)
        answer = SimpleNamespace(results=[SimpleNamespace(successful=True, reason='')])
        return SimpleNamespace(done=lambda: True, result=lambda: answer)


def says(ticks, name='/worn/controller_node'):
    status = DiagnosticStatus(name=name, values=[KeyValue(key='ticks', value=ticks)])
    return DiagnosticArray(status=[status])


@pytest.fixture
def told():
    """A controller that was told of a model, and who told it."""
    controller = Controller()
    believing = Believing(SimpleNamespace(create_client=lambda *_: controller), 'controller_node', lambda _: None)
    for _ in range(4):
        believing.believe(ADOPTED)
    assert controller.told == [ADOPTED]
    return controller, believing


def test_a_controller_that_was_gone_is_told_again(told):
    controller, believing = told
    for ready in (False, True):
        controller.ready = ready
        for _ in range(4):
            believing.believe(ADOPTED)
    assert controller.told == [ADOPTED, ADOPTED]


@pytest.mark.parametrize('muscle', ['', '/thumb'])
def test_a_controller_whose_ticks_begin_anew_is_told_again_though_nobody_saw_it_gone(told, muscle):
    """Killed and begun again within the discovery lease."""
    controller, believing = told
    for ticks, times in (('900', 1), ('1000', 1), ('20', 2), ('120', 2), ('none', 2)):
        believing.hear(says(ticks, f'/worn/controller_node{muscle}'))
        believing.hear(says('1', '/worn/controller_node_2'))
        for _ in range(4):
            believing.believe(ADOPTED)
        assert controller.told == [ADOPTED] * times


def test_a_controller_that_was_told_nothing_is_left_alone_when_it_begins_anew(told):
    controller, believing = told
    for _ in range(4):
        believing.believe('')
    for ticks in ('900', '20'):
        believing.hear(says(ticks))
        believing.believe('')
    assert controller.told == [ADOPTED, '']
