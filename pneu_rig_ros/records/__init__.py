"""Validated, time-aligned signals with units; rosbag2 directories with MCAP storage in and out."""

from pneu_rig_ros.records.reader import read_recording
from pneu_rig_ros.records.recording import Recording
from pneu_rig_ros.records.repair import RepairReport, repair
from pneu_rig_ros.records.writer import BagWriter

__all__ = ['BagWriter', 'Recording', 'RepairReport', 'read_recording', 'repair']
