asm too_many
signature:
definitions:
  rule r_0 = a :=
  rule r_1 = a := //~ L058
  rule r_2 = a := //~ L058
  rule r_3 = a := //~ L058
  rule r_4 = a := //~ L058
  rule r_5 = a := //~ L058
  rule r_6 = a := //~ L058
  rule r_7 = a := //~ L058
  rule r_8 = a := //~ L058
  rule r_9 = a := //~ L058
  rule r_10 = a := //~ L058
  rule r_11 = a := //~ L058
  rule r_12 = a := //~ L058
  rule r_13 = a := //~ L058
  rule r_14 = a := //~ L058
  rule r_15 = a := //~ L058
  rule r_16 = a := //~ L058
  rule r_17 = a := //~ L058
  rule r_18 = a := //~ L058
  rule r_19 = a := //~ L058
  rule r_20 = a := //~ L058
  rule r_21 = a := //~ L058
  rule r_22 = a := //~ L058
  rule r_23 = a := //~ L058
  rule r_24 = a := //~ L058
  rule r_25 = a := //~ L058
  rule r_26 = a := //~ L058
  rule r_27 = a := //~ L058
  rule r_28 = a := //~ L058
  rule r_29 = a := //~ L058
  rule r_30 = a := //~ L058
  rule r_31 = a := //~ L058
  rule r_32 = a := //~ L058
  rule r_33 = a := //~ L058
  rule r_34 = a := //~ L058
  rule r_35 = a := //~ L058
  rule r_36 = a := //~ L058
  rule r_37 = a := //~ L058
  rule r_38 = a := //~ L058
  rule r_39 = a := //~ L058
  rule r_40 = a := //~ L058
  rule r_41 = a := //~ L058
  rule r_42 = a := //~ L058
  rule r_43 = a := //~ L058
  rule r_44 = a := //~ L058
  rule r_45 = a := //~ L058
  rule r_46 = a := //~ L058
  rule r_47 = a := //~ L058
  rule r_48 = a := //~ L058
  rule r_49 = a := //~ L058
  rule r_50 = a := //~ L058 L062
  rule r_51 = a :=
  rule r_52 = a :=
  rule r_53 = a :=
  rule r_54 = a :=
  rule r_55 = a :=
  rule r_56 = a :=
  rule r_57 = a :=
  rule r_58 = a :=
  rule r_59 = a :=
