"""The plant with an optional effect, beside the plant without it; needs no ROS."""

import numpy as np

from pneu_rig_ros.model.effects.chamber_leak import Parameters
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig import load_configuration

COMMAND, INTERVAL, DURATION = 0.34, 1.16e-3, 10.0  # V, s, s

model = load_configuration('cylinder_2').model
leak = {'chamber_leak': Parameters(area_1=3e-8, area_2=0.0)}  # m^2
voltages = np.tile((2.5 + COMMAND, 2.5 - COMMAND), (round(DURATION / INTERVAL), 1))

for title, effects in {'tight': {}, 'leaking': leak}.items():
    run = Plant(model, effects).run(voltages, INTERVAL)
    print(
        f'{title}: {(run.position[-1] - run.position[0]) * 1e3:.1f} mm in {run.time[-1]:.2f} s, '
        f'{run.pressure_1[-1] / 1e5:.3f} bar in chamber 1'
    )
