"""
A compiler of blocks: functions that are compiled into others, and called by no one else.

Numba optimises every function together with all that it calls, generates machine code for it, and
does the same again with whatever calls it. For blocks that is a third of the time to compile a
plant, and nothing of it is used: the outermost function is optimised as a whole. Numba lets a
function have a compiler of its own by ``pipeline_class`` (Numba's developer manual, "Customizing
the Compiler").

A block has no environment: an exception that it raises may have constant arguments only, and it
cannot print.
"""

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering


class BlockLibrary(JITCodeLibrary):
    """The code of a block as it is linked into that of its callers."""

    def _optimize_final_module(self) -> None:
        """Leave it to the outermost function."""

    def _finalize_final_module(self) -> None:
        """Generate no machine code."""
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class BlockLowering(NativeLowering):
    """Lowering to a :class:`BlockLibrary`, which callers link."""

    _name = 'block_lowering'

    def run_pass(self, state: Any) -> bool:
        """Lower a block; register it under a key in place of the function that Python calls."""
        library = BlockLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library, state.flags.no_compile = library, True
        super().run_pass(state)
        # what callers look the block up by; it raises if Python calls the block
        key: Any = {}.__getitem__
        state.targetctx.insert_user_function(key, state['cr'].fndesc, [library])
        state['cr'] = state['cr']._replace(cfunc=key)
        return True


class BlockCompiler(CompilerBase):
    """Numba's compiler with that lowering."""

    def define_pipelines(self) -> list[Any]:
        """Return the passes."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        names = [each for each, _ in passes.passes]
        index = names.index(NativeLowering)
        passes.passes[index] = BlockLowering, passes.passes[index][1]
        passes.finalize()
        return [passes]
