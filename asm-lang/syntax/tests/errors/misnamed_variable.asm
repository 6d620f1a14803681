asm misnamed_variable
signature:
definitions:
  main rule r_Main = forall x in s do skip //~ L056
