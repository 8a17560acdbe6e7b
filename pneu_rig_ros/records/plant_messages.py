"""All messages of one sampling instant of the rig."""

from pneu_rig_ros.records.cdr import pack_clock, pack_float64, template
from pneu_rig_ros.records.topics import CLOCK
from pneu_rig_ros.rig import Sample


class PlantMessages:
    """
    The messages of one sampling instant, ready to publish or to write.

    :param pressure_variance: variance of the pressure sensors [Pa^2]
    :param frame_prefix: of the frames in the headers
    :param clock: whether the plant is the clock
    """

    def __init__(
        self, pressure_variance: float, frame_prefix: str = '', clock: bool = False
    ) -> None:
        self._joint_states = template('joint_states', frame_prefix)
        self._pressure = template('chamber_1/pressure', frame_prefix, pressure_variance)
        self._has_clock = clock

    def pack(self, sample: Sample, stamp_ns: int) -> dict[str, bytes]:
        """Return topic -> message of a sample (SI) at a stamp [ns], in the order of publishing."""
        position, velocity = sample.position, sample.velocity
        messages = {
            'joint_states': self._joint_states.at(stamp_ns, position, velocity),
            'position': pack_float64(position),
            'velocity': pack_float64(velocity),
            'chamber_1/pressure': self._pressure.at(stamp_ns, sample.pressure_1),
            'chamber_2/pressure': self._pressure.at(stamp_ns, sample.pressure_2),
        }
        if self._has_clock:
            messages[CLOCK] = pack_clock(stamp_ns)
        return messages
