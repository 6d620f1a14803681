asm unused_try
signature:
definitions:
  main rule r_Main = try a := 1 catch a skip //~ L057
