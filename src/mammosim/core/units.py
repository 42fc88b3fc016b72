"""The unit system: mm, kPa, mN, uJ, g/cm3, keV, mGy. Conversions happen at borders, by these names."""

# Weight density of 1 g/cm3 under standard gravity, in kPa/mm (9.81e-3 mN/mm3).
KPA_PER_MM_PER_G_CM3 = 9.81e-3

MN_PER_N = 1e3
UJ_PER_MJ = 1e3
UGY_PER_MGY = 1e3
MM3_PER_CM3 = 1e3
MM_PER_CM = 10.0
G_PER_KG = 1e3
J_PER_KEV = 1.602176634e-16  # exact, SI 2019
MGY_PER_GY = 1e3
