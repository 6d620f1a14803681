// without definition it is undef
asm static_without_definition
import StandardLibrary
signature:
  static nothing: Integer
  controlled x: Integer
definitions:
  main rule r_Main = x := nothing
//= step 1: x := undef
