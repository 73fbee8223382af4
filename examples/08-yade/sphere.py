import sys

import numpy as np
import sluice
from yade import *  # what `yade` gives to its scripts


def solve(self):
    """A sphere over a floor, moved by YADE under the loads of a fluid."""
    config = self.config
    position, radius = config.numbers("position", 3, unit="m"), config.number("radius", unit="m")
    density, weight = config.number("density", unit="kg/m3"), config.number("weight", unit="m/s2")
    step = config.number("step", unit="s")
    self.sends("kinematics")
    self.takes("load")
    config.finish()
    if self.checking:
        return
    fluid = self.receivers("kinematics")[0]

    gravity = Vector3(0, 0, -weight)  # less the buoyancy
    matter = O.materials.append(FrictMat(young=1e5, poisson=0.3, frictionAngle=0, density=density))
    grains = [O.bodies.append(utils.sphere(tuple(position), radius, material=matter))]
    O.bodies.append(utils.wall(0, axis=2, material=matter))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()],
                        [Law2_ScGeom_FrictPhys_CundallStrack()]),
        NewtonIntegrator(gravity=gravity, damping=0),
    ]
    state = [O.bodies[i].state for i in grains]

    def tell():
        column = lambda name: np.array([getattr(s, name) for s in state])
        self.write(fluid, "kinematics", np.array(grains, np.int64), position=column("pos"), velocity=column("vel"),
                   angular_velocity=column("angVel"), radius=np.full(len(grains), radius))

    tell()
    for window in self.windows():
        load = self.read(fluid, "load", window)
        steps = window.steps(step)
        O.dt = window.length / steps
        if window.index == 0 or O.iter == 0:  # YADE's velocities are those of half a step before: leapfrog
            for s in state:
                s.vel -= O.dt / 2 * gravity
        for k in range(steps):
            now = load.at(window.time(k, steps))
            for row, grain in enumerate(now.ids):
                O.forces.setPermF(int(grain), Vector3(*now.force[row]))
                O.forces.setPermT(int(grain), Vector3(*now.torque[row]))
            O.step()
        tell()
    self.fact("height at the end [m]", state[0].pos[2])


sluice.run(solve, sys.yade_argv[sys.yade_argv.index("sphere.py"):])
