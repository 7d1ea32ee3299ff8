"""What happens within a tick of a controller, of which no one knows when it falls."""

from rcc_sim.jit import jit


@jit
def share_beyond(beyond, change):
    """Share [1] of a tick in which something is beyond a limit: its mean.

    ``beyond`` says by how much it is at the tick, ``change`` by how much it changes
    from one to the next. A step from none to all would make everything leap that
    depends on the moment.
    """
    if beyond >= 0.5 * change:
        return 1.0
    if beyond <= -0.5 * change:
        return 0.0
    return 0.5 + beyond / change
