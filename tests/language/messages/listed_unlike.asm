asm listed_unlike
import StandardLibrary
signature:
  controlled s: Powerset(Integer)
definitions:
  main rule r_Main = s := {1, "two"}  //~ A019
