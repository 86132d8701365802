"""A robot as its file roots it, standing on one sole: the oracle of the re-rooted model."""

import numpy as np
import pinocchio as pin

from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.importer import ImportedRobot, import_robot
from gaitopt.model.joint_tree import lock_upper_body, reroot


class PelvisRooted:
    """Free-flyer at the root and n joints, in a random state with the stance sole at rest."""

    def __init__(self, model: pin.Model, sole: str, names: tuple[str, ...], seed: int) -> None:
        rng = np.random.default_rng(seed)
        n = len(names)
        self.angles = rng.uniform(-0.8, 0.8, n)
        self.rates, self.accelerations = rng.normal(0.0, 3.0, n), rng.normal(0.0, 30.0, n)
        self.model, self.data = model, model.createData()
        self.columns = [model.joints[model.getJointId(n)].idx_v for n in names]
        self.sole = model.getFrameId(sole)
        self.q = pin.neutral(model)
        self.q[[c + 1 for c in self.columns]] = self.angles
        self._stand_on_the_sole()
        self.v, self.a = np.zeros(6 + n), np.zeros(6 + n)
        self.v[self.columns], self.a[self.columns] = self.rates, self.accelerations
        self._hold_the_sole()

    def _stand_on_the_sole(self) -> None:
        pin.framesForwardKinematics(self.model, self.data, self.q)
        self.q[:7] = pin.SE3ToXYZQUAT(self.data.oMf[self.sole].inverse())

    def jacobian(self) -> np.ndarray:
        pin.computeJointJacobians(self.model, self.data, self.q)
        pin.updateFramePlacements(self.model, self.data)
        return pin.getFrameJacobian(self.model, self.data, self.sole, pin.LOCAL).copy()

    def _hold_the_sole(self) -> None:
        """Base twist and acceleration that keep the stance sole at rest."""
        J = self.jacobian()
        self.v[:6] = -np.linalg.solve(J[:, :6], J[:, 6:] @ self.v[6:])
        pin.forwardKinematics(self.model, self.data, self.q, self.v, self.a)
        drift = pin.getFrameAcceleration(self.model, self.data, self.sole, pin.LOCAL).vector
        self.a[:6] = -np.linalg.solve(J[:, :6], drift)

    def placements(self) -> dict[str, np.ndarray]:
        """Of every body frame, in the world of the stance sole."""
        pin.framesForwardKinematics(self.model, self.data, self.q)
        bodies = (f for f in self.model.frames if f.type == pin.FrameType.BODY)
        return {f.name: self.data.oMf[self.model.getFrameId(f.name)].homogeneous for f in bodies}

    def effort(self) -> np.ndarray:
        """Ground wrench in the sole frame, then torques: the base carries nothing itself."""
        tau = pin.rnea(self.model, self.data, self.q, self.v, self.a)
        J = self.jacobian()
        wrench = np.linalg.solve(J[:, :6].T, tau[:6])
        return np.concatenate([wrench, (tau - J.T @ wrench)[self.columns]])

    def mass_matrix(self) -> np.ndarray:
        """In the coordinates of the re-rooted model: sole twist, then joint rates."""
        M = pin.crba(self.model, self.data, self.q).copy()
        J = self.jacobian()
        # Pelvis-rooted velocity from (sole twist, joint rates): the sole twist is J v.
        order = np.array(self.columns)
        to_base = np.linalg.inv(J[:, :6])
        V = np.zeros(M.shape)
        V[:6, :6], V[:6, 6:] = to_base, -to_base @ J[:, order]
        V[order, range(6, len(M))] = 1.0
        return V.T @ M @ V

    def state(self, model: pin.Model) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same state of the re-rooted model."""
        q = pin.neutral(model)
        q[7:] = self.angles
        zero = np.zeros(6)
        return q, np.r_[zero, self.rates], np.r_[zero, self.accelerations]


def rooted_both_ways(reading: ImportedRobot, seed: int) -> tuple[pin.Model, PelvisRooted]:
    """A robot re-rooted at its stance sole and rooted at its pelvis, nothing made symmetric."""
    reduced = lock_upper_body(reading.model, *reading.sole_names, reading.q)
    model = reroot(reduced, *reading.sole_names)
    names = tuple(str(n) for n in model.names[2:])
    return model, PelvisRooted(reduced, reading.sole_names[0], names, seed)


def reading_of(urdf: object, choices: ImportOptions | None = None) -> ImportedRobot:
    """What is read from a URDF."""
    choices = choices or ImportOptions()
    return import_robot(read_source(urdf, choices.package_dirs), choices)
