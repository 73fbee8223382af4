import math

import numpy as np
import sluice


def solve(self):
    """A disc that a constant force pulls through a fluid; per metre of depth."""
    radius, density = self.config.number("radius", unit="m"), self.config.number("density", unit="kg/m3")
    position = self.config.numbers("position", 2, unit="m")
    pull = self.config.numbers("pull", 2, unit="N/m")
    self.sends("kinematics")
    self.takes("load")
    self.config.finish()
    if self.checking:
        return

    def tell():
        self.write("water", "kinematics", np.zeros(1, np.int64), position=position, velocity=velocity,
                   angular_velocity=np.zeros(1), radius=np.array([radius]))

    velocity = np.zeros(2)  # m/s
    mass = density * math.pi * radius**2  # kg/m
    rows = ["time [s],impulse_x [N s/m],impulse_y [N s/m],momentum_x [N s/m],momentum_y [N s/m]"]
    tell()
    for window in self.windows():
        impulse = self.read("water", "load", window).at(window.end).force.sum(axis=0) * window.length
        velocity += (pull * window.length + impulse) / mass
        position += velocity * window.length
        tell()
        rows.append(",".join(map(repr, map(float, [window.end, *impulse, *(mass * velocity)]))))
    (self.directory / "disc.csv").write_text("\n".join(rows) + "\n")
    self.fact("velocity at the end [m/s]", velocity[0])


sluice.run(solve)
