"""`python -m pneu_rig_ros.cli` is `pneu-rig`."""

from pneu_rig_ros.cli import main

if __name__ == '__main__':
    raise SystemExit(main())
