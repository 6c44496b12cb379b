"""Tables of laws without a name, and stick-slip, in the nodes: real processes, with a parameter file."""

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParametersAtomically
from rclpy.parameter import Parameter

from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.muscle.quantities import IN_ZERO
from tcp_muscle_ros.settings.parameter_file import read

pytestmark = pytest.mark.processes

HOT, LOAD = 60.0, 0.5
FILE = """/**:
  ros__parameters:
    effects: [free_stroke, stick_slip]
    free_stroke:
      driver: temperature
      at: [290, 320, 350, 390]
      value: [0.0, -2.0e-3, 1.0e-2, 9.0e-2]
    stick_slip: {Fb: 1.0e-3, seed: 7.0}
"""


def shown(parameters: Parameters, before: Parameters | None = None) -> float:
    """The displacement (m) of a muscle that was put together hot; on the ruler of what it was ``before``, if given."""
    muscle, at_first = (Muscle(p, load=LOAD, ambient=HOT + 273.15) for p in (parameters, before or parameters))
    muscle.imposed[IN_ZERO] = at_first.imposed[IN_ZERO]
    return muscle.reading(0.0).displacement


@pytest.fixture(scope='module')
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp('laws') / 'muscle.yaml'
    path.write_text(FILE)
    return path


def test_sim_node_has_tables_as_arrays_and_changes_them_as_a_whole(bench, file):
    displacement = bench.listen('/laws/displacement')
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    program = bench.start('sim_node', 'laws', '--params-file', str(file), load_n=LOAD, ambient_temperature_c=HOT)
    bench.until(lambda: displacement, 'sim_node publishes nothing', 120.0)
    model = read(file).parameters
    assert displacement.last.data == pytest.approx(shown(model), abs=1e-9)

    names = ['free_stroke.at', 'free_stroke.cooling', 'free_stroke.driver', 'stick_slip.seed']
    at, cooling, driver, seed = bench.call(GetParameters, '/laws/sim_node/get_parameters', names=names).values
    assert list(at.double_array_value) == [290.0, 320.0, 350.0, 390.0]
    assert list(cooling.double_array_value) == [0.0, -2e-3, 1e-2, 9e-2]
    assert (driver.string_value, seed.double_value) == ('temperature', 7.0)
    (row,) = bench.call(DescribeParameters, '/laws/sim_node/describe_parameters', names=names[:1]).descriptors
    assert row.additional_constraints.startswith('2 to 8 numbers')

    def change(**values) -> str:
        given = [Parameter(f'free_stroke.{name}', value=value).to_parameter_msg() for name, value in values.items()]
        reply = bench.call(SetParametersAtomically, '/laws/sim_node/set_parameters_atomically', parameters=given)
        return reply.result.reason

    assert "'free_stroke.value'" in (said := change(at=[300.0, 310.0])) and 'expected as many' in said
    assert change(driver='time').startswith("parameter 'free_stroke.driver' is 'temperature' as long as the node runs")
    assert change(at=[300.0, 310.0], value=[0.0, -5e-3], cooling=[0.0, -5e-3]) == ''
    wanted = shown(model.replace({f'free_stroke.{n}_{k}': v for n, (a, b) in (
        ('at', (300.0, 310.0)), ('value', (0.0, -5e-3)), ('cooling', (0.0, -5e-3)),
    ) for k, v in ((1, a), (2, b))} | {'free_stroke.knots': 2.0}), model)  # fmt: skip
    bench.until(lambda: abs(displacement.last.data - wanted) < 2e-3, 'the table was not taken over')
    bench.until(
        lambda: any('outside the table' in s.message for _, a in diagnostics[-5:] for s in a.status),
        'it does not say so',
    )
    program.kill()
    bench.forget(displacement, diagnostics)


def test_the_controller_refuses_what_lies_beyond_the_turn_of_a_table(bench, file):
    shaped = bench.listen('/turn/shaped_setpoint')
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    program = bench.start('controller_node', 'turn', '--params-file', str(file), load_n=LOAD, feedback_timeout_s=5.0)
    setpoint, measured = bench.speaker('/turn/displacement_setpoint'), bench.speaker('/turn/displacement')

    def refused() -> bool:
        """Of what it was told to count."""
        return any(
            value.key == 'refused_inputs' and value.value.startswith('displacement_setpoint')
            for _, array in diagnostics[-5:] for status in array.status for value in status.values
            if status.name == '/turn/controller_node'
        )  # fmt: skip

    with bench.repeating(measured, 0.0), bench.repeating(setpoint, 0.004) as want:
        bench.until(lambda: shaped and abs(shaped.last.data - 0.004) < 1e-6, 'it does not take what it can do')
        assert not refused()
        want(0.06)
        bench.until(refused, 'not refused')
        assert shaped.last.data == pytest.approx(0.004, abs=1e-6)
    program.kill()
    bench.forget(shaped, diagnostics)
