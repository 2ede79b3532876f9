"""SINUMERIK 840D sl.

Axis values are machine positions: transformations, tool offsets and zero offsets are off, `SUPA` suppresses
what is left of them in every motion. `G93`: F is the reciprocal of the time for the block in minutes, here
the largest speed of the block's path parameter, so it holds for linear and rotary axes alike and for any
FGREF; `FGROUP` makes all seven path axes. F is at most 999999.999: shorter blocks run slower than planned,
never faster. Acceleration and jerk are the axes' own (`SOFT`), which must be those of the machine
definition named in the header. `G60 G601` stops exactly at the end of every block and is never taken back;
the compressor is off.

`H1=` hands the PLC the number of a die, `H2=` that of a process, `H3=` that of a hand-shake, as the header
lists them; the PLC acknowledges every M function before the next block runs. It acknowledges `M62` when the
hand-shake's signal is there, and stops the machine with an alarm when the time in its name is over without.
Where the machine is not where the program starts, alarm 65000 ends it before anything moves.
"""

from robots.post.events import EVENT_CALLS
from robots.post.form import AXES, Form
from robots.post.grammar import Calls, Grammar

CALLS = Calls(
    start="H1={k} M59", change="H1={k} M60", process="H2={k} M61", wait="H3={k} M62", events=EVENT_CALLS
)

GRAMMAR = Grammar(
    form=Form(feed_digits=3, max_feed=999_999.999),
    top=(),
    note="; {}",
    opening=(
        "G17 G40 G90 G710",
        "TRAFOOF",
        "G500 D0",
        "G60 G601 COMPOF FFWOF SOFT",
        "FGROUP(X,Y,Z,A,B,W,C)",
        "G93",
    ),
    rest=("N{n} ; {why}",),
    motion=("N{n} G1 SUPA X{X} Y{Y} Z{Z} A{A} B{B} W{W} C{C} F{F} ; {why}",),
    position=tuple(f"IF ABS($AA_IM[{axis}]-({{{axis}}}))>0.05 GOTOF NOT_AT_START" for axis in AXES),
    closing=("M30", "NOT_AT_START:", "SETAL(65000)", "M30"),
    calls=CALLS,
    width=512,
)
