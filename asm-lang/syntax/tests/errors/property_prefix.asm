asm property_prefix
signature:
definitions:
  invariant positive over a: a > 0 //~ L075
  CTLSPEC safe: a //~ L075
