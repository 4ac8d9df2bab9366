# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
From a CSV file of one joint to a friction law, a figure and a diagnosis, in Python.

Run it with ``python examples/pendulum.py``: it writes the folder ``pendulum_output``.
``examples/pendulum.ipynb`` is made from this file by ``python examples/make_notebook.py``.
"""

# %% [markdown]
# # Friction of a pendulum on a geared motor
#
# All that this page needs is time, position and motor current of one joint in a CSV file, and what
# is known of the robot: a URDF, the rotor's inertia, the torque constant.

# %%
import csv
import math
import random
from pathlib import Path

import matplotlib.pyplot as plt

import sosml_friction as sf

OUTPUT = Path('pendulum_output')
OUTPUT.mkdir(exist_ok=True)

# %% [markdown]
# ## 1. A recording
#
# Bring your own CSV file, or take this one: a pendulum that follows slow and fast sweeps under a
# PD controller, integrated in steps of 0.1 ms. The gear has Coulomb and viscous friction, and it
# cogs: twelve times a turn its torque rises and falls by 0.12 Nm.

# %%
MASS, LENGTH, ROTOR = 1.2, 0.25, 0.03  # kg, m, kg m2 at the joint
TORQUE_CONSTANT = 2.0  # Nm at the joint per A
COULOMB, VISCOUS, COGGING, PERIODS = 0.5, 0.15, 0.12, 12
STEP, SAMPLE, DURATION = 1e-4, 2e-3, 16.0  # s


def wanted(t):
    """Return the position [rad] and velocity [rad/s] that the controller follows."""
    slow, fast = 2 * math.pi * 0.11, 2 * math.pi * 0.47
    position = 0.9 * math.sin(slow * t) + 0.35 * math.sin(fast * t)
    return position, 0.9 * slow * math.cos(slow * t) + 0.35 * fast * math.cos(fast * t)


def simulate_pendulum(path):
    """Write time [s], position [deg] and current [A] of a simulated run."""
    chance = random.Random(1)
    inertia = ROTOR + MASS * LENGTH**2
    encoder = 360.0 / 2**16  # deg
    q, v, torque = 0.0, wanted(0.0)[1], 0.0
    with path.open('w', newline='', encoding='utf-8') as file:
        rows = csv.writer(file)
        rows.writerow(['time', 'position', 'current'])
        for k in range(round(DURATION / STEP)):
            t = k * STEP
            if k % round(SAMPLE / STEP) == 0:
                aim, speed = wanted(t)
                torque = 60.0 * (aim - q) + 3.0 * (speed - v)
                position = encoder * round(math.degrees(q) / encoder)
                current = torque / TORQUE_CONSTANT + chance.gauss(0.0, 0.003)
                rows.writerow([f'{t:.4f}', f'{position:.6f}', f'{current:.4f}'])
            friction = COULOMB * math.tanh(v / 2e-3) + VISCOUS * v
            cogging = COGGING * math.sin(PERIODS * q)
            weight = MASS * 9.81 * LENGTH * math.sin(q)
            v += STEP * (torque - friction - cogging - weight) / inertia
            q += STEP * v


simulate_pendulum(OUTPUT / 'pendulum.csv')

# %% [markdown]
# ## 2. Read it
#
# A mapping says which column is what, in which unit. A current is no torque until `scale` says how
# many Nm one A makes.

# %%
(OUTPUT / 'mapping.yaml').write_text(
    f"""\
time: {{variable: time, unit: s}}
joints:
  pivot:
    position: {{variable: position, unit: deg}}
    effort: {{variable: current, unit: A, scale: {TORQUE_CONSTANT}}}
""",
    encoding='utf-8',
)
log = sf.load(OUTPUT / 'pendulum.csv', OUTPUT / 'mapping.yaml')
print(log)

# %% [markdown]
# ## 3. What is known of the robot
#
# The bodies come from a URDF. The rotor's inertia at the joint is not in it, and is given apart.

# %%
URDF = f"""\
<robot name="pendulum">
  <link name="base"/>
  <link name="arm">
    <inertial>
      <origin xyz="0 0 {-LENGTH}"/>
      <mass value="{MASS}"/>
      <inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/>
    </inertial>
  </link>
  <joint name="pivot" type="revolute">
    <parent link="base"/>
    <child link="arm"/>
    <axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="10" effort="20"/>
  </joint>
</robot>
"""
model = sf.Model.from_urdf(URDF, armature={'pivot': ROTOR})
print(model)

# %% [markdown]
# ## 4. Fit friction
#
# The current is a command that is held until the next sample; of one that was measured at its
# stamp say `effort_hold={'pivot': 'mean'}`.

# %%
fit = sf.fit(log, model)
print(fit.summary())
for name, (low, high) in fit.conf_int()['pivot'].items():
    print(f'{name}: {low:.4g} to {high:.4g}' if low < high else f'{name}: open')
fit.model.write(OUTPUT / 'model')

# %% [markdown]
# ## 5. A figure
#
# Points: what an observer says of every tenth sample. Line: the law that was fitted.

# %%
observation = sf.observe(log, model, observers=['sosml'])
slope = [(b - a) / (2 * SAMPLE * 10) for a, b in zip(log.q[:-20, 0], log.q[20:, 0], strict=True)]
speeds = [0.02 * k for k in range(-100, 101)]
figure, axes = plt.subplots(figsize=(7.0, 4.5), layout='constrained')
friction = observation.friction['sosml'][10:-10, 0]
axes.plot(slope[::10], friction[::10], '.', color='0.7', label='SOSML')
axes.plot(speeds, fit.predict(speeds), color='C0', label='fitted law')
axes.set(xlabel='velocity [rad/s]', ylabel='friction [Nm]')
axes.legend()
figure.savefig(OUTPUT / 'friction.png', dpi=150)

# %% [markdown]
# ## 6. What does the fitted model get wrong?
#
# The law knows speed only. The diagnosis looks for what else is in the data.

# %%
diagnosis = sf.diagnose(log, fit.model)
print(diagnosis.summary())

# %% [markdown]
# ## 7. Is the extended model better?

# %%
print('fitted:  ', sf.simulate(log, fit.model))
print('extended:', diagnosis.predict(log))
diagnosis.write(OUTPUT / 'diagnosis')
