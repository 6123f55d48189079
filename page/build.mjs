// Makes dist/page.html: one file with style, script and a policy that lets it fetch nothing; and dist/licences.txt.
import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const here = new URL(".", import.meta.url);
const text = (path) => readFileSync(new URL(path, here), "utf8");
const hash = (of) => `'sha256-${createHash("sha256").update(of, "utf8").digest("base64")}'`;

const bundled = async (entry, more) => {
  const made = await build({ entryPoints: [new URL(entry, here).pathname], absWorkingDir: here.pathname, bundle: true, minify: true, write: false, legalComments: "none", charset: "utf8", ...more });
  return made.outputFiles[0].text.trim();
};

const licences = ["three", "uplot"].map((name) => {
  const { version, license } = JSON.parse(text(`node_modules/${name}/package.json`));
  return `${name} ${version} (${license})\n\n${text(`node_modules/${name}/LICENSE`).trim()}\n`;
}).join("\n----------------------------------------------------------------------\n\n");

// In a script element "</script" ends it, and "<!--" keeps that from ending it.
const script = (await bundled("src/main.ts", { format: "esm", target: "es2022" })).replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
const style = `${await bundled("src/page.css", {})}\n${text("node_modules/uplot/dist/uPlot.min.css").trim()}`;
const policy = `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; img-src data: blob:; base-uri 'none'; form-action 'none'`;

const parts = { POLICY: policy, STYLE: style, SCRIPT: script };
const page = text("src/page.html").replace(/@(POLICY|STYLE|SCRIPT)@/g, (_, name) => parts[name]);
const notice = `<!--\nThird-party parts of this page:\n\n${licences.replaceAll("--", "- -")}-->\n`;
mkdirSync(new URL("dist/", here), { recursive: true });
writeFileSync(new URL("dist/page.html", here), page.replace("<head>", () => `<head>\n${notice}`));
writeFileSync(new URL("dist/licences.txt", here), licences);
