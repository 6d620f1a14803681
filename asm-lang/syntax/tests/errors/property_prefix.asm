asm property_prefix
signature:
definitions:
  invariant positive over a: a > 0 //~ L055
  CTLSPEC safe: a //~ L055
