"""Errors of the mechanism, as its public edge reports them."""


class MechanismError(ValueError):
    """A mechanism, a position or a set of shoulder angles that cannot be."""


class GeometryError(MechanismError):
    """Dimensions that no mechanism can have; the message names field, value and bound."""


class UnreachableError(MechanismError):
    """A position, or a set of shoulder angles, in which the chains cannot be closed."""


class BranchError(UnreachableError):
    """A position, or a set of shoulder angles, that closes the chains in another assembly than the machine's own."""


class SingularError(MechanismError):
    """A pose in which the map between joint rates and platform velocity does not exist."""
