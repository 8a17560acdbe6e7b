"""Independent tasks on one processor, on many, or on many machines: one interface, on Dask."""

from pneu_rig_ros.executor.tasks import Executor, Here, executor, map_tasks

__all__ = ['Executor', 'Here', 'executor', 'map_tasks']
