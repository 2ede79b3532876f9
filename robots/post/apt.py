"""APT source (ISO 4343 words), for a post-processor of the machine's own.

Axis values are machine positions, not positions of a tool in the part: `GOTO/` and `FROM/` hold X Y Z, and
the statements with `NEXT` before them the other axes of the same motion, so that all seven move at once and
straight. `FEDRAT/f,INVERS` is an inverse time feed: the reciprocal of the time for the block in minutes, here
the largest speed of the block's path parameter. `MCHTOL/0` allows no deviation at corners: exact stop
everywhere. `SEQNO/` begins a block and `PPRINT` says why it is there: both are for people.

`FROM/` says where the machine must stand when the program starts; the post-processor has to see to that.
`TOOLNO/` is the die that must be in the machine, `LOADTL/` a die change, `AUXFUN/701` and on the processes,
numbered as the header lists them, `AUXFUN/801` and on the hand-shakes (wait for the signal, an alarm when the
time in its name is over), `AUXFUN/101` and on the events. Lines have at most 72 characters, those of
the header apart, which are comments.
"""

from robots.post.events import EVENT_CALLS
from robots.post.form import Form
from robots.post.grammar import Calls, Grammar

CALLS = Calls(
    start="TOOLNO/{k}",
    change="LOADTL/{k}",
    process="AUXFUN/7{k:02d}",
    wait="AUXFUN/8{k:02d}",
    events={code: f"AUXFUN/{call.removeprefix('M')}" for code, call in EVENT_CALLS.items()},
)

_OTHER_AXES = (
    "ROTABL/AAXIS,ATANGL,{A},NEXT",
    "ROTABL/BAXIS,ATANGL,{B},NEXT",
    "ROTABL/CAXIS,ATANGL,{C},NEXT",
    "POSITN/WAXIS,{W},NEXT",
)

GRAMMAR = Grammar(
    form=Form(),
    top=("PARTNO RIVETPLAN",),
    note="$$ {}",
    opening=("UNITS/MM", "MULTAX/OFF", "MCHTOL/0"),
    rest=("SEQNO/{n}", "PPRINT {why}"),
    motion=("SEQNO/{n}", "PPRINT {why}", "FEDRAT/{F},INVERS", *_OTHER_AXES, "GOTO/{X},{Y},{Z}"),
    position=(*_OTHER_AXES, "FROM/{X},{Y},{Z}"),
    closing=("END", "FINI"),
    calls=CALLS,
    width=80,
)
