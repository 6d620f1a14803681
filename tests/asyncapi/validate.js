// Holds the document on standard input against the published schema of AsyncAPI 3.0.0.
const { createRequire } = require('module');
const fs = require('fs');

// the packages are where this is called, not where it stands
const packages = createRequire(process.cwd() + '/');
const Ajv = packages('ajv');
const schema = packages('@asyncapi/specs/schemas/3.0.0.json');

// the validator has draft 07 already
delete schema.definitions['http://json-schema.org/draft-07/schema'];
const validate = new Ajv({ strict: false, allErrors: true, validateFormats: false }).compile(schema);
if (!validate(JSON.parse(fs.readFileSync(0, 'utf8')))) {
  console.error(JSON.stringify(validate.errors.slice(0, 8), null, 1));
  process.exit(1);
}
