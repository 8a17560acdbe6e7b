"""
Weak and strong strengths of the second list of forms, for each cylinder [SI]; zero is none.

Found for each cylinder by simulating the third experiment of ``experiments.FIT``, shapes in the
middle of their ranges, by bisection of the logarithm: the weak one changes a signal by 3 times the
noise of its sensor (root mean square), the strong one by 60, where it is still physical. It is not
beyond that for a spool that would hunt across its dead band, friction that falls by more than half
or doubles, an average over 50 ms, an error of 1.8 mm within a period, and all there is of a film
or a dwell (cylinder 3: 14, 25); a dry joint shows by 1 to 13 as stiff as 1e-5 m/N, by 13 to 21
as soft as 1e-3 m/N.
"""

SECOND_STRENGTHS: dict[str, tuple[tuple[float, float], ...]] = {
    'inflow_heat': ((0.012, 0.27), (0.023, 0.6), (0.061, 4.2)),
    'cracking_regulator': ((1100.0, 22000.0), (1800.0, 36000.0), (3800.0, 76000.0)),
    'round_ports': ((0.0021, 0.042), (0.0045, 0.09), (0.011, 0.22)),
    'pressed_slit_leak': ((4.5e-18, 9.1e-17), (1.5e-17, 3e-16), (4.5e-17, 1e-15)),
    'one_way_lip_leak': ((1.9e-19, 3.8e-18), (8.3e-19, 1.7e-17), (6.7e-18, 1.4e-16)),
    'notched_land_leak': ((2.1e-14, 4.4e-13), (4.8e-14, 9.5e-13), (1.1e-13, 1.9e-12)),
    'eddy_current_spool': ((0.0056, 0.11), (0.011, 0.22), (0.02, 0.41)),
    'bouc_wen_spool': ((0.0003, 0.0061), (0.00068, 0.014), (0.0016, 0.033)),
    'darcy_line': ((0.027, 0.56), (0.055, 1.1), (0.065, 1.4)),
    'hunting_spool': ((0.026, 0.14), (0.035, 0.14), (0.053, 0.14)),
    'warming_coil': ((0.00082, 0.016), (0.0011, 0.022), (0.0022, 0.043)),
    'side_volume': ((2.1e-07, 4.1e-06), (8e-07, 1.6e-05), (2.6e-06, 5.8e-05)),
    'thirion_seal': ((0.085, 1.7), (0.67, 12.0), (3.5, 67.0)),
    'side_loaded_rod': ((0.0055, 0.1), (0.025, 0.48), (0.019, 0.5)),
    'warming_and_cooling': ((0.0057, 0.12), (0.037, 1.2), (0.11, 1.2)),
    'root_of_speed_outward': ((0.13, 2.8), (0.4, 9.2), (0.86, 18.0)),
    'relaxing_lip': ((0.005, 0.1), (0.021, 0.42), (0.068, 1.9)),
    'tanh_curve': ((0.12, 2.5), (0.13, 2.7), (1.7, 19.0)),
    'squeezed_out_dwell': ((0.0023, 0.052), (0.0091, 0.21), (0.016, 1.0)),
    'entrained_film': ((0.0069, 0.13), (0.0049, 0.14), (0.11, 1.0)),
    'rubber_cord': ((0.014, 0.28), (0.066, 1.3), (0.22, 4.4)),
    'needle_cushion': ((5.5, 87.0), (5.6, 120.0), (4.6, 180.0)),
    'dry_joint': ((1e-05, 0.001), (1e-05, 0.001), (1e-05, 0.001)),
    'holding_magnet': ((0.33, 5.3), (2.1, 31.0), (6.2, 120.0)),
    'eddy_current_brake': ((0.025, 0.51), (0.16, 3.4), (0.56, 13.0)),
    'loaded_potentiometer': ((0.0022, 0.045), (0.0015, 0.031), (0.0014, 0.029)),
    'averaged_position': ((0.0029, 0.05), (0.0048, 0.05), (0.0081, 0.05)),
    'interpolated_position': ((6.9e-05, 0.0014), (0.0001, 0.0018), (0.0001, 0.0018)),
}
"""Form -> weak and strong, for cylinder 1, 2, 3."""
