"""Where a user's own effects enter the kernel; shipped effects do not pass here.

Without such an effect ``EXTRA`` is False, and the machine code holds nothing of this.
With one, ``simulate/own.py`` puts True and functions that call it in their place.
"""

from rcc_sim.jit import jit

EXTRA = False
"""Whether the vehicle has effects of the user's own."""


@jit
def act(p, c, s, u, f, v, w, a):
    """Set pull [N] on the vehicle, twist [N m] on the shaft, draw [W] on the battery.

    At the speed v [m/s], that of the wheels w, and the acceleration a [m/s²].
    """


@jit
def book_extra(c, f, E, ds, dw):
    """Book forces over the distance ds [m], torques over that of the wheels dw."""


@jit
def book_draw(f, E, dt):
    """Book what is drawn from the battery over the time dt [s]."""
