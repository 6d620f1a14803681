asm too_large
import StandardLibrary
signature:
  controlled s: Powerset(Integer)
definitions:
  main rule r_Main = s := {1 : 10000000}  //~ R012
